"""Small shapes for the tests of pictures: vertices (V, 3), faces (F, 3), normals (V, 3)."""

from __future__ import annotations

import numpy as np

BARE = np.array([244, 243, 238], dtype=np.uint8)
INK = np.array([22, 20, 21], dtype=np.uint8)


def grid_faces(rows: int, columns: int) -> np.ndarray:
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    first = np.stack([corner, corner + 1, corner + columns + 1], axis=1)
    second = np.stack([corner, corner + columns + 1, corner + columns], axis=1)
    return np.concatenate([first, second]).astype(np.int32)


def sheet(width: float, height: float, n: int = 41) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.linspace(0, width, n), np.linspace(0, height, n))
    vertices = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3).astype(np.float32)
    return vertices, grid_faces(n, n), np.tile(np.float32([0, 0, 1]), (n * n, 1))


def ball(radius: float = 20.0, n: int = 60) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    down, turn = np.meshgrid(np.linspace(1e-3, np.pi - 1e-3, n), np.linspace(0, 2 * np.pi, 2 * n))
    level = np.sin(down)
    normals = np.stack([level * np.cos(turn), level * np.sin(turn), np.cos(down)], axis=-1)
    normals = normals.reshape(-1, 3).astype(np.float32)
    return radius * normals, grid_faces(2 * n, n), normals
