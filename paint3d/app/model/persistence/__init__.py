"""What outlasts the studio: settings, the history of a session, what a crash would lose."""
