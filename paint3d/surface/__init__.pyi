from paint3d.surface.layer_stack import Layer as Layer
from paint3d.surface.layer_stack import LayerStack as LayerStack
from paint3d.surface.painted_surface import PaintedSurface as PaintedSurface
from paint3d.surface.state import restore_surface as restore_surface
from paint3d.surface.state import surface_state as surface_state
from paint3d.surface.undo import UndoHistory as UndoHistory
from paint3d.surface.undo_state import restore_undo as restore_undo
