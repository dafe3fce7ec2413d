"""What is to be seen of a painting: pictures, films, and the light they are seen in."""
