"""Long work beside the window: opening, saving, films, replays."""
