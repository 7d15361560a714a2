"""Figures of results: frozen classes that can also be read like dicts (`stats["pairs"]`, `dict(stats)`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

from feeler.field_docs import documented

Number = TypeVar("Number", int, float)


class _Figures(Mapping[str, Number]):
    """The fields of a dataclass as a mapping, without those that are None."""

    def __getitem__(self, name: str) -> Number:
        if name not in self._names():
            raise KeyError(name)
        value: Number = getattr(self, name)
        return value

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def _names(self) -> list[str]:
        kind: Any = self
        return [each.name for each in fields(kind) if getattr(self, each.name) is not None]


# Compared like dicts: with `eq`, a dataclass would equal none.


@documented
@dataclass(frozen=True, eq=False)
class CollisionStats(_Figures[int]):
    """Counters of a query, stage by stage: `Collision.stats`."""

    voxels_visited: int
    """Voxels looked up; with blocks, nodes tested: against one box their 32 children, against 16 their own box."""
    clusters_placed: int
    """With blocks: clusters of 16 pieces of the tool that were placed."""
    pieces_scanned: int
    """With blocks: pieces of the mock-up whose boxes were compared with those of the 16 pieces of a cluster."""
    entries_scanned: int
    """Pairs of tool triangle and list entry; with blocks, pairs of pieces with overlapping boxes."""
    box_survivors: int
    """Pairs of triangles with overlapping boxes."""
    repeats_skipped: int
    """Repeated pairs that were skipped."""
    triangle_tests: int
    """Pairs of triangles that were tested."""
    exact_tests: int
    """Triangle tests that needed exact arithmetic because float64 could not decide them."""
    pairs: int
    """Distinct colliding pairs."""


@documented
@dataclass(frozen=True, eq=False)
class SceneMemory(_Figures[int]):
    """Bytes by structure: `Scene.memory()`. Structures that the scene does not have are None, and no keys."""

    triangles: int
    """The mock-up's own triangles, which the index reads and does not copy."""
    parts: int
    """The mock-up's own parts."""
    total: int
    """All that stays in memory for the index."""
    blocks: int | None = None
    """Storage `blocks`."""
    tree: int | None = None
    """Storage `blocks`: the tree above the blocks."""
    pieces: int | None = None
    """Storage `blocks`: the triangles, cut."""
    voxels: int | None = None
    """Storage `dense` and `hashed`: the array of voxels."""
    lists: int | None = None
    """Storage `dense` and `hashed`: the triangles of each voxel."""
    occupancy: int | None = None
    """Storage `dense` and `hashed`: which voxels have triangles."""
    adjacency: int | None = None
    """Which triangles are neighbours: built by the first query that needs it."""
    selection: int | None = None
    """Which parts are present: of scenes that `without` and `only` made."""


@documented
@dataclass(frozen=True, eq=False)
class DeviceLimits(_Figures[float]):
    """The limits of a haptic device: `Device.limits`. 0: none, or not known."""

    force_n: float
    """The largest force."""
    torque_nm: float
    """The largest torque."""
    stiffness_n_per_m: float
    """Largest stable value."""
    rotational_stiffness_nm_per_rad: float
    """Largest stable value."""
    damping_n_s_per_m: float
    """Viscous, its own."""
    rotational_damping_nm_s_per_rad: float
    """Viscous, its own."""
    friction_n: float
    """Coulomb."""
    rotational_friction_nm: float
    """Coulomb."""
    resolution_m: float
    """Smallest step of the measured position."""
    rotational_resolution_rad: float
    """Smallest step of the measured orientation."""
    rate_hz: float
    """How often it takes a force each second."""
    delay_s: float
    """From the measured position to the force on the hand."""
