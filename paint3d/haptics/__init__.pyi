from .servo import ForceFeedback as ForceFeedback
from .servo import ServoStatus as ServoStatus
from .settings import DeviceLimits as DeviceLimits
from .settings import HapticSettings as HapticSettings
