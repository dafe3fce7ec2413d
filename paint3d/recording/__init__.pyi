from paint3d.recording.recording import Recording as Recording
from paint3d.recording.recording import load_recording as load_recording
from paint3d.recording.recording import save_recording as save_recording
