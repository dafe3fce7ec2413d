from . import errors as errors
from .api.painter import Painter as Painter
from .brush.presets import load_brush as load_brush
from .colour.layers import mixture_reflectance as mixture_reflectance
from .colour.materials import load_material as load_material
from .device.sample import DeviceSample as DeviceSample
from .files.export import export as export
from .files.export_options import ExportOptions as ExportOptions
from .files.load import load_mesh as load_mesh
from .files.project.session import Session as Session
from .files.project.session import load_session as load_session
from .files.project.session import save_session as save_session
from .mesh.triangle_mesh import TriangleMesh as TriangleMesh
from .page.notebook import edit as edit
from .painter.stroke_table import StrokeTable as StrokeTable
from .recording.recording import Recording as Recording
from .recording.recording import load_recording as load_recording
from .recording.recording import save_recording as save_recording
from .surface.painted_surface import PaintedSurface as PaintedSurface

__version__: str
