"""Force feedback: its settings, the servo's process, and shared memory."""
