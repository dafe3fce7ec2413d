from .model.document import Document as Document
from .model.paint_thread import PaintThread as PaintThread
from .model.persistence.recovery_folder import RecoveryFolder as RecoveryFolder
from .model.persistence.recovery_folder import recoverable as recoverable
from .window.start import run_studio as run_studio
from .window.studio import StudioWindow as StudioWindow
