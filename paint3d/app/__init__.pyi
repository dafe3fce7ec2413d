from .model.document import Document as Document
from .model.easel import Easel as Easel
from .model.persistence.sitting import Sitting as Sitting
from .model.persistence.sitting import recoverable as recoverable
from .window.start import run_studio as run_studio
from .window.studio import StudioWindow as StudioWindow
