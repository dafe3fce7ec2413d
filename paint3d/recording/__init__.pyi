from paint3d.recording.recording import Recording as Recording
from paint3d.recording.recording import load_recording as load_recording
from paint3d.recording.recording import save_recording as save_recording
from paint3d.recording.score import Score as Score
from paint3d.recording.score import load_score as load_score
from paint3d.recording.score import save_score as save_score
