from paint3d.haptics.servo import ForceFeedback as ForceFeedback
from paint3d.haptics.servo import ServoStatus as ServoStatus
from paint3d.haptics.settings import DeviceLimits as DeviceLimits
from paint3d.haptics.settings import HapticSettings as HapticSettings
