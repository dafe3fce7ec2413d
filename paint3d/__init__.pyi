from paint3d import errors as errors
from paint3d.colour.layers import mixture_reflectance as mixture_reflectance
from paint3d.files.export import export as export
from paint3d.files.export_options import ExportOptions as ExportOptions
from paint3d.files.load import load_mesh as load_mesh
from paint3d.files.project.session import Session as Session
from paint3d.files.project.session import load_session as load_session
from paint3d.files.project.session import save_session as save_session
from paint3d.mesh.triangle_mesh import TriangleMesh as TriangleMesh
from paint3d.painter.painter import Painter as Painter
from paint3d.recording.recording import Recording as Recording
from paint3d.recording.recording import load_recording as load_recording
from paint3d.surface.painted_surface import PaintedSurface as PaintedSurface

__version__: str
