from .layer_stack import Layer as Layer
from .layer_stack import LayerStack as LayerStack
from .painted_surface import PaintedSurface as PaintedSurface
from .state import restore_surface as restore_surface
from .state import surface_state as surface_state
from .undo import UndoHistory as UndoHistory
from .undo_state import restore_undo as restore_undo
