"""Scenes: what is modelled, and how."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from microslip import _native
from microslip.errors import InputError

__all__ = ["Scene", "benchmarks"]


def benchmarks() -> list[str]:
    """Names of the scenes that come with the package.

    Returns
    -------
    list of str
        As :meth:`Scene.benchmark` takes them.

    Examples
    --------
    >>> import microslip
    >>> "brake-reuss-beam/brb-quick" in microslip.benchmarks()
    True
    """
    return _native.benchmarks()


class Scene:
    """What is modelled, and how: structure, interfaces, bolts and analyses.

    A scene is checked when it is made, and does not change. It is made by :meth:`from_file`, :meth:`from_dict`, :meth:`from_json`
    or :meth:`benchmark`. Every field is described in the guide *Scenes*. Scenes are equal if all their fields are; they can be
    pickled.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick")
    >>> scene
    Scene('brb-quick')
    >>> scene.replace({"interfaces.mu": 0.3}).to_dict()["interfaces"]["mu"]
    0.3
    """

    __slots__ = ("_handle", "_state")

    _handle: _native.Scene
    _state: tuple[str, str]

    def __init__(self, native: _native.Scene) -> None:
        if not isinstance(native, _native.Scene):
            raise InputError(
                "a scene is made by Scene.from_file, Scene.from_dict, Scene.from_json or Scene.benchmark",
                remedy="call one of Scene.from_file, Scene.from_dict, Scene.from_json and Scene.benchmark",
            )
        self._handle = native
        self._state = native.state()

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Scene:
        """Read a scene file.

        Parameters
        ----------
        path : path-like
            JSON with comments. Paths in it are relative to its folder.

        Raises
        ------
        FileError
            The file cannot be read.
        SceneError
            It is malformed, or a value is out of range.

        Examples
        --------
        >>> import microslip, pathlib, tempfile
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "joint.json"
        >>> _ = path.write_text('{"units": {"length": "m", "mass": "kg", "time": "s"}, "structure": {"benchmark": "brake-reuss-beam"}}')
        >>> microslip.Scene.from_file(path).name
        'joint'
        """
        return cls(_native.Scene.from_file(os.fspath(path)))

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any], directory: str | os.PathLike[str] | None = None) -> Scene:
        """Make a scene of what a scene file would hold.

        Parameters
        ----------
        fields : mapping
            The fields of a scene file, in the units that its ``units`` declares. NumPy numbers and arrays and paths are understood.
        directory : path-like, optional
            Folder that relative paths start from; the current one by default.

        Raises
        ------
        SceneError
            A field is missing, unknown, or has a value out of range.
        InputError
            A value is nothing that a scene file can hold.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.from_dict({
        ...     "units": {"length": "mm", "mass": "t", "time": "s"},
        ...     "structure": {"benchmark": "brake-reuss-beam"},
        ...     "bolts": {"load": "12 kN"},
        ... })
        >>> scene.to_dict()["bolts"]["load"]
        12000.0
        """
        return cls._parse(_encoded(fields), directory)

    @classmethod
    def from_json(cls, text: str, directory: str | os.PathLike[str] | None = None) -> Scene:
        """Make a scene of the text of a scene file.

        Parameters
        ----------
        text : str
            JSON with comments.
        directory : path-like, optional
            Folder that relative paths start from; the current one by default.

        Raises
        ------
        SceneError
            The text is malformed, or a value is out of range.

        Examples
        --------
        >>> import microslip
        >>> text = '''{
        ...     "units": {"length": "m", "mass": "kg", "time": "s"},
        ...     "structure": {"benchmark": "brake-reuss-beam"} // all else by default
        ... }'''
        >>> microslip.Scene.from_json(text).name
        'scene'
        """
        return cls._parse(text, directory)

    @classmethod
    def benchmark(cls, name: str) -> Scene:
        """A scene that comes with the package.

        Parameters
        ----------
        name : str
            ``"BENCHMARK"`` for its first scene, or ``"BENCHMARK/SCENE"``; :func:`benchmarks` lists them.

        Raises
        ------
        SceneError
            There is none of this name.

        Examples
        --------
        >>> import microslip
        >>> microslip.Scene.benchmark("brake-reuss-beam/brb-flat").name
        'brb-flat'
        """
        return cls(_native.Scene.benchmark(name))

    @property
    def name(self) -> str:
        """Name of the scene: its own, or that of its file.

        Examples
        --------
        >>> import microslip
        >>> microslip.Scene.benchmark("brake-reuss-beam/brb-quick").name
        'brb-quick'
        """
        return self._handle.name

    def to_dict(self) -> dict[str, Any]:
        """All fields with all defaults, in SI.

        Returns
        -------
        dict
            What :meth:`from_dict` would make the same scene of.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam")
        >>> microslip.Scene.from_dict(scene.to_dict()) == scene
        True
        """
        fields: dict[str, Any] = json.loads(self._state[0])
        return fields

    def replace(self, changes: Mapping[str, Any] | None = None, /, **fields: Any) -> Scene:
        """The scene with other values of some fields.

        Parameters
        ----------
        changes : mapping, optional
            Values by the paths of their fields, such as ``{"bolts.load": "9 kN"}``. Numbers are in SI; a value replaces all that was
            there. ``None`` takes a field back to its default.
        **fields
            The same for fields without a dot in their path.

        Raises
        ------
        SceneError
            A value is out of range, or a field is unknown.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam")
        >>> other = scene.replace({"bolts.load": "9 kN", "interfaces.mu": 0.4}, name="rough")
        >>> other.to_dict()["bolts"]["load"], other.to_dict()["interfaces"]["mu"], other.name
        (9000.0, 0.4, 'rough')
        """
        changed = self.to_dict()
        for path, value in {**(changes or {}), **fields}.items():
            *blocks, last = path.split(".")
            block = changed
            for name in blocks:
                below = block.get(name)
                block[name] = below = {} if below is None else below
                if not isinstance(below, dict):
                    raise InputError(
                        f"{path}: {name} is no block of fields; give the whole of it",
                        field=path,
                        remedy="give the whole of it",
                    )
                block = below
            if value is None:
                block.pop(last, None)
            else:
                block[last] = value
        return self._parse(_encoded(changed), None)

    @classmethod
    def _parse(cls, text: str, directory: str | os.PathLike[str] | None) -> Scene:
        folder = None if directory is None else os.fspath(directory)
        return cls(_native.Scene.from_json(text, "the scene", "scene", folder))

    @classmethod
    def _from_state(cls, scene: str, source: str) -> Scene:
        return cls(_native.Scene.from_state(scene, source))

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene._from_state, self._state

    def __eq__(self, other: object) -> bool:
        return self._state[0] == other._state[0] if isinstance(other, Scene) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._state[0])

    def __repr__(self) -> str:
        return f"Scene({self.name!r})"


def _encoded(fields: Mapping[str, Any]) -> str:
    """What a scene file would hold, as JSON."""
    try:
        return json.dumps(fields, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"the scene cannot be written as JSON: {error}", field="fields") from error


def _plain(value: Any) -> Any:
    """A value that JSON does not know, as one that it knows."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    # Arrays and numbers of NumPy.
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is nothing that a scene file can hold")
