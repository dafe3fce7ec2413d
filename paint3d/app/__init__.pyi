from paint3d.app.model.document import Document as Document
from paint3d.app.model.easel import Easel as Easel
from paint3d.app.model.persistence.sitting import Sitting as Sitting
from paint3d.app.model.persistence.sitting import recoverable as recoverable
from paint3d.app.window.start import run_studio as run_studio
from paint3d.app.window.studio import StudioWindow as StudioWindow
