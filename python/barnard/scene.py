"""Scenes: what is in front of the telescope, and the telescope."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from . import _barnard, _scene_files
from ._bundle import packed, page_of, page_path
from ._field import Field, Sampled
from ._progress import Listener, listening
from ._rows import scene_error, unknown_key
from ._table import Table, checked, copied, table_of
from ._session import Session
from ._tree import LISTS, PARTS, TABLES, list_of, place_of, take, tree_of
from .fit import Fit, FitModel, FreeKeys, Images, model_of
from .image import Image
from .parameters import Parameter, parameters_of
from .plan import Plan, backend_options
from .plates import Plates, wavelengths
from .sequence import FrameSequence
from .tables import Animation, Background, Band, Camera, Detail, Display, Dust, Emission, Frames, Gas, Instrument, Method, Observation, Output, Spectrograph, Star, StarTable

#: Largest size of a packed scene in a notebook [MB].
_LARGEST_VIEW = 4.0

if TYPE_CHECKING:
    from typing import Generic, TypeVar

    Own = TypeVar("Own", bound=Table)

    class Part(Generic[Own]):
        """A table of a scene: set as an object or a dictionary of its keys, read as an object."""

        def __get__(self, scene: Scene, owner: type[Scene]) -> Own: ...
        def __set__(self, scene: Scene, value: Own | dict[str, Any] | None) -> None: ...


class Scene:
    """A nebula with stars, camera and method.

    Attributes are the tables of scene files, with lists (`stars`, `emission`, `star_tables`, `passbands`) and dictionaries
    by name (`fields`, `bookmarks`) of repeated tables. A dictionary of keys can replace any table. A scene can be changed
    at any time; the next render reuses everything that is still valid.

    Parameters
    ----------
    bands : text or list of texts, default "johnson"
        A set of passbands, or a list of embedded ones; `barnard.catalogue("passband-sets")` names them.
    camera : Camera
        The default camera of `render`.
    fields : dictionary of fields by name
        Scalar fields for expressions such as `Dust.density`. Arrays require a box: `Grid(array, low=..., high=...)`.
    dust, gas, background, detail, spectrograph, display, observation, instrument, output, method, sequence : table or dictionary, optional
        See `Dust`, `Gas`, `Background`, `Detail`, `Display`, `Method` and `Frames`.
    stars, emission, star_tables, passbands, animation : lists of tables or dictionaries, optional
        See `Star`, `Emission`, `StarTable`, `Band` and `Animation`.
    bookmarks : dictionary of cameras by name, optional
    name, description : text, optional
    folder : path, default the working directory
        Folder of the files of the scene.
    memory : number, default 16
        Memory limit of one array, grid or image [GiB].

    Raises
    ------
    SceneError
        For wrong types and unknown keys. `check`, `plan` and `render` report values out of range and conflicts. `key` is the
        location, such as `star[2].temperature`.
    """

    if TYPE_CHECKING:
        # A part that a scene lacks is None; type checkers take it to be there, so that `scene.dust.scale = ...` passes.
        camera: Part[Camera] = Part()
        dust: Part[Dust] = Part()
        gas: Part[Gas] = Part()
        background: Part[Background] = Part()
        detail: Part[Detail] = Part()
        spectrograph: Part[Spectrograph] = Part()
        display: Part[Display] = Part()
        observation: Part[Observation] = Part()
        instrument: Part[Instrument] = Part()
        output: Part[Output] = Part()
        method: Part[Method] = Part()
        sequence: Part[Frames] = Part()

    def __init__(
        self,
        *,
        bands: str | Sequence[str] | None = None,
        camera: Camera | dict[str, Any] | None = None,
        fields: Mapping[str, Field | dict[str, Any]] | None = None,
        dust: Dust | dict[str, Any] | None = None,
        gas: Gas | dict[str, Any] | None = None,
        emission: Iterable[Emission | dict[str, Any]] = (),
        stars: Iterable[Star | dict[str, Any]] = (),
        star_tables: Iterable[StarTable | dict[str, Any]] = (),
        background: Background | dict[str, Any] | None = None,
        detail: Detail | dict[str, Any] | None = None,
        spectrograph: Spectrograph | dict[str, Any] | None = None,
        passbands: Iterable[Band | dict[str, Any]] = (),
        bookmarks: Mapping[str, Camera | dict[str, Any]] | None = None,
        display: Display | dict[str, Any] | None = None,
        observation: Observation | dict[str, Any] | None = None,
        instrument: Instrument | dict[str, Any] | None = None,
        output: Output | dict[str, Any] | None = None,
        method: Method | dict[str, Any] | None = None,
        animation: Iterable[Animation | dict[str, Any]] = (),
        sequence: Frames | dict[str, Any] | None = None,
        name: str | None = None,
        description: str | None = None,
        folder: str | os.PathLike | None = None,
        memory: float = 16.0,
    ):
        if not 0 < memory < 1e6:
            raise scene_error("memory", f"{memory} is out of range; give a number of GiB such as 8")
        self._limit = int(memory * 2**30)
        self._folder: str | None = os.fspath(folder) if folder is not None else os.curdir
        self._forget()
        self.name, self.description, self.bands = name, description, bands
        self.camera, self.dust, self.gas, self.background = camera, dust, gas, background
        self.detail, self.spectrograph = detail, spectrograph
        self.display, self.observation, self.instrument, self.output = display, observation, instrument, output
        self.method, self.sequence = method, sequence
        self.fields: dict[str, Field] = cast("dict[str, Field]", dict(fields or {}))
        self.bookmarks: dict[str, Camera] = cast("dict[str, Camera]", dict(bookmarks or {}))
        self.emission: list[Emission] = list_of(emission, "emission")
        self.stars: list[Star] = list_of(stars, "stars")
        self.star_tables: list[StarTable] = list_of(star_tables, "star_tables")
        self.passbands: list[Band] = list_of(passbands, "passbands")
        self.animation: list[Animation] = list_of(animation, "animation")

    def _forget(self) -> None:
        self._reader: _barnard.Reader | None = None
        self._current: Session | None = None
        self._plan: dict[str, _barnard.Plan] = {}
        self._planned: Plan | None = None

    def _twin(self) -> Scene:
        """A scene that says the same and can be changed apart; arrays, and what was made before, are shared."""
        twin = object.__new__(type(self))
        memo: dict[int, Any] = {}
        for name, value in self.__dict__.items():
            object.__setattr__(twin, name, value if name.startswith("_") else copied(value, memo))
        object.__setattr__(twin, "_planned", None)
        return twin

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            if name not in PARTS:
                raise unknown_key("", name, PARTS)
            if name in TABLES and value is not None:
                value = table_of(TABLES[name], value, name)
            if name in LISTS:
                value = list_of(value, name)
        super().__setattr__(name, value)

    def __getstate__(self) -> dict[str, Any]:
        state = {name: value for name, value in self.__dict__.items() if name not in ("_reader", "_current", "_plan", "_planned")}
        return {"version": _barnard.__version__, "scene": state}

    def __setstate__(self, state: dict[str, Any]) -> None:
        if state.get("version") != _barnard.__version__:
            raise _barnard.BarnardError(
                f"the scene was pickled by barnard {state.get('version')}, this is {_barnard.__version__}: "
                "store scenes with Scene.save, or pickle it again"
            )
        self.__dict__.update(state["scene"])
        self._forget()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in PARTS)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        parts = ", ".join(f"{name}={getattr(self, name)!r}" for name in PARTS if getattr(self, name))
        return f"Scene({parts})"

    # The tree of a scene file.

    @classmethod
    def builtin(cls, name: str, *, memory: float = 16.0) -> Scene:
        """A built-in scene; `barnard.catalogue("scenes")` lists them.

        Raises
        ------
        SceneError
            If the name is unknown.
        """
        scene = cls._of(_barnard.from_toml(f"built-in {name}", _barnard.builtin_text(name)), name, memory)
        scene._folder = None
        return scene

    @classmethod
    def from_toml(cls, source: str | os.PathLike, *, memory: float = 16.0) -> Scene:
        """Reads a scene from a file, or from its text (of more than one line).

        Files of the scene are relative to the file, or to the working directory.

        Raises
        ------
        SceneError
            If the text is not a valid scene; the message has file, line and key.
        """
        if isinstance(source, str) and "\n" in source:
            return cls._of(_barnard.from_toml("scene", source), None, memory)
        path = Path(source)
        if path.suffix == ".barnard":
            raise _barnard.SceneError(f"{path}: is a packed scene, which the command and the explorer open; give the scene it was made from")
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise _barnard.SceneError(f"{path}: cannot be read: {error}") from None
        scene = cls._of(_barnard.from_toml(str(path), text), path.stem, memory)
        scene._folder = os.fspath(path.parent)
        return scene

    @classmethod
    def _of(cls, tree: dict[str, Any], name: str | None, memory: float) -> Scene:
        scene = cls(memory=memory)
        if name is not None:
            scene.name = name
        take(scene, tree)
        return scene

    def _arrays(self) -> dict[str, Sampled]:
        return {name: field for name, field in self.fields.items() if isinstance(field, Sampled) and field.values is not None}

    def _refuse_bricks(self) -> None:
        for name, field in self.fields.items():
            if isinstance(field, Sampled) and field.bricks is not None:
                raise scene_error(f"field.{name}", "the field is bricked; use barnard.render_bricks(scene), or gather it with .compute() first")

    to_toml = _scene_files.to_toml
    save = _scene_files.save
    to_html = _scene_files.to_html
    _packed = _scene_files.packed_scene

    def _tree(self, camera: Camera | dict[str, Any] | None = None) -> dict[str, Any]:
        return tree_of(self, camera)

    # Rendering.

    def _session(self, camera: Camera | dict[str, Any] | None = None) -> Session:
        """The scene as it is now, or with another camera, for the native module."""
        self._refuse_bricks()
        tree = self._tree(camera)
        if self._current is None or self._current.tree != tree:
            self._current = Session(tree, self._reading(), self._limit)
        return self._current

    def _reading(self) -> _barnard.Reader:
        """Loader of the scene, with the arrays of its fields."""
        if self._reader is None:
            self._reader = _barnard.Reader(self._folder, self._limit)
        arrays = {field._nodes()["file"]: (name, np.asarray(field.values)) for name, field in self._arrays().items()}
        self._reader.keep_arrays(list(arrays))
        for file, (name, values) in arrays.items():
            self._reader.add_array(file, f"the array of field {name}", values)
        return self._reader

    def parameters(self) -> dict[str, Parameter]:
        """Every value that can be swept, animated or fitted, by path, with type, unit, range and current value.

        >>> scene.parameters()["star[0].temperature"].value
        """
        return parameters_of(self._tree())

    def check(self) -> None:
        """Checks that the scene can be rendered.

        Raises
        ------
        SceneError
            If it cannot; `key` is the location.
        """
        _ = self._session().scene

    def plan(
        self,
        camera: Camera | dict[str, Any] | None = None,
        *,
        backend: str = "cpu",
        progress: bool | Listener | None = None,
    ) -> Plan:
        """Precomputed data of the scene: spectral rules, star depths, steps, and their errors.

        Valid parts of an earlier plan of the same scene are reused, with the same bits.

        Parameters
        ----------
        camera : Camera, optional
            Camera instead of the scene's.
        backend : text, default "cpu"
            Back end of the plan.
        progress : true or callable (stage, done, all), optional

        Raises
        ------
        SceneError, MemoryLimitError
        KeyboardInterrupt
            After Ctrl-C; the scene is unchanged.
        """
        session = self._session(camera)
        # Where nothing changed since, the plan of before is this one.
        if self._planned is not None and self._planned._session is session and self._planned._backend == backend:
            return self._planned
        with listening(progress) as listener:
            plan = _barnard.plan(session.scene, self._plan.get(backend), backend, session.limit, progress=listener)
        self._plan = {backend: plan}
        self._planned = Plan(self, session, plan, backend)
        return self._planned

    def plates(self, range: tuple[Any, Any] | None = None, *, dust: tuple[float, float] = (1, 1), progress: bool | Listener | None = None) -> Plates:
        """The picture per light, to change spectra, luminosities, passbands, albedo and amount of dust without rendering again.

        Parameters
        ----------
        range : pair of wavelengths, optional
            Wavelength range of later passbands, such as ("380 nm", "1 um"). Default: those of the scene, extended by a tenth.
        dust : pair of numbers, default (1, 1)
            Range of later amounts of dust relative to the scene's, such as (0.5, 2).
        progress : true or callable (stage, done, all), optional

        Raises
        ------
        SceneError, MemoryLimitError
        KeyboardInterrupt
            After Ctrl-C.
        """
        session = self._session()
        with listening(progress) as listener:
            return Plates(_barnard.plates(session.scene, wavelengths(range), (dust[0], dust[1]), self._plan.get("cpu"), session.limit, progress=listener))

    def fit_model(
        self,
        free: FreeKeys,
        to: Images,
        *,
        sigma: Any = None,
        mask: Any = None,
        assume: str | Sequence[str] = (),
        progress: bool | Listener | None = None,
    ) -> FitModel:
        """The scene as a model of observed images.

        Parameters
        ----------
        free : dictionary from keys to Free, to (low, high) or to None; or list of keys
            Free keys of the scene, such as {"star[0].temperature": bn.Free(5e3 * u.K, 4e4 * u.K), "dust.scale": None}, with bounds
            and priors. The values of the scene are the start.
        to : path, Image or array, or list of them and of pairs
            FITS files: one image HDU per passband, by name; standard errors as NAME_error or ERR; a mask as mask.NAME, DQ or MASK;
            "file.fits[SCI,2]" selects one HDU. Images have their own unit and sky position; arrays are bands × height × width
            (height × width of one band), first row on top, in the unit of the scene's pictures. A pair is an image and a
            dictionary of overrides: instrument, bands, camera, observation, sigma, mask.
        sigma : array or number, optional
            Standard errors of arrays and images in their unit, broadcast to their shape.
        mask : array, optional
            Pixels of arrays and images to ignore.
        assume : "unit", "place", or both, optional
            Missing metadata of files to assume from the scene: unit (BUNIT), sky position (WCS).

        Raises
        ------
        SceneError
            If images cannot be read or have other pixels, passbands or units, or a free key has no number.
        """
        with listening(progress) as listener:
            return model_of(self, free, to, {"sigma": sigma, "mask": mask}, assume, listener)

    def fit(
        self,
        free: FreeKeys,
        to: Images,
        *,
        sigma: Any = None,
        mask: Any = None,
        assume: str | Sequence[str] = (),
        progress: bool | Listener | None = None,
    ) -> Fit:
        """Fits free keys of the scene to observed images; see `fit_model` for the parameters.

        Raises
        ------
        SceneError
            Errors of `fit_model`, and if the data do not depend on a key.
        KeyboardInterrupt
            After Ctrl-C.
        """
        return self.fit_model(free, to, sigma=sigma, mask=mask, assume=assume, progress=progress).fit(progress=progress)

    def render(
        self,
        camera: Camera | dict[str, Any] | None = None,
        *,
        backend: str = "cpu",
        progress: bool | Listener | None = None,
        accuracy: float | None = None,
        samples: int | None = None,
        target_error: float | None = None,
        seed: int | None = None,
    ) -> Image:
        """Renders the scene, with the bits of `barnard render`.

        Parameters
        ----------
        camera : Camera, optional
            Camera instead of the scene's.
        backend : text, default "cpu"
            "cpu", "gpu", "auto", "path" or "reference"; see `barnard.catalogue("backends")`.
        progress : true or callable (stage, done, all), optional
        accuracy : number, optional
            Allowed relative error of each pixel, for "reference"; others use `Method.accuracy`.
        samples, target_error, seed : numbers, optional
            Paths per pixel, relative standard error at which to stop, and seed, for "path".

        Raises
        ------
        SceneError, MemoryLimitError, DeviceError
        KeyboardInterrupt
            After Ctrl-C.
        """
        options = backend_options(backend, accuracy, samples, target_error, seed)
        if backend in ("path", "reference"):
            session = self._session(camera)
            with listening(progress) as listener:
                return Image(_barnard.render(session.scene, None, backend, options, session.limit, progress=listener))
        with listening(progress) as listener:
            plan = self.plan(camera, backend=backend, progress=listener)
            return plan._render(plan._session.scene, plan._plan, listener)

    def frames(self) -> FrameSequence:
        """The frames of a scene with a camera path, animated keys or a sequence.

        Raises
        ------
        SceneError
            If the scene is static, or a frame is invalid.
        """
        self._refuse_bricks()
        frames = FrameSequence(self)
        frames._sequence()
        return frames

    def sweep(
        self,
        parameters: Mapping[str, Iterable[Any]] | None = None,
        *,
        backend: str = "cpu",
        progress: bool | Listener | None = None,
        **more: Iterable[Any],
    ) -> Iterator[Image]:
        """Renders the scene for a list of values; each picture recomputes only what changes.

        Parameters
        ----------
        parameters : dictionary from places to values
            Keys such as "star[0].temperature" or "dust.scale"; parts of the scene can be keywords, as in
            `scene.sweep(camera=cameras)`. Several parameters change together.

        Yields
        ------
        Image
            Its `parameters` are its values. The sweep uses a copy: the scene does not change.

        Raises
        ------
        SceneError
            If a key is unknown, or the parameters have different numbers of values.
        """
        for place, values in {**(parameters or {}), **more}.items():
            if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__") or getattr(values, "shape", None) == ():
                raise scene_error(place, f"{values!r} is a single value; a sweep requires a list, such as [{values!r}]")
        swept = {place: list(values) for place, values in {**(parameters or {}), **more}.items()}
        counts = {len(values) for values in swept.values()}
        if len(counts) != 1:
            told_counts = ", ".join(f"{place}: {len(values)}" for place, values in swept.items()) or "none is there"
            raise scene_error("sweep", f"all parameters must have the same number of values, and one parameter is required ({told_counts})")
        twin = self._twin()
        places = {place: place_of(twin, place) for place in swept}
        if any(place.startswith("field") for place in swept):
            # Arrays that are swept must not take the place of those of this scene.
            twin._forget()
        return twin._swept(swept, places, counts.pop(), backend, progress)

    def _swept(self, swept, places, count, backend, progress) -> Iterator[Image]:
        for i in range(count):
            for place, (owner, key) in places.items():
                setattr(owner, key, swept[place][i])
            image = self.render(backend=backend, progress=progress)
            image.parameters = {place: values[i] for place, values in swept.items()}
            yield image

    def explore(
        self,
        sliders: Mapping[str, tuple[Any, Any]] | None = None,
        *,
        size: tuple[int, int] = (640, 360),
        in_browser: bool | None = None,
        **display: Any,
    ) -> Any:
        """A live view for notebooks: drag to orbit, wheel to zoom, sliders for keys of the scene; requires anywidget.

        The browser renders it, without the kernel: the scene is packed once, as by `save("scene.barnard")`. Where that cannot be, the
        kernel renders.

        Parameters
        ----------
        sliders : dictionary from places to (low, high), optional
            Such as {"star[0].temperature": (3000 * u.K, 40000 * u.K)}.
        size : (width, height), default (640, 360)
            Pixels of the view.
        in_browser : bool, optional
            True for the browser, False for the kernel. Default: the browser, unless this installation lacks the page of the
            explorer, or a slider moves a key of a field.
        **display : keys of `Display`
            Such as palette="sho". Default: those of the scene.

        Returns
        -------
        Explorer
            A widget that edits this scene.

        Raises
        ------
        SceneError
            If the scene cannot be rendered, or the key of a slider is unknown.
        BarnardError
            If anywidget is not installed.
        """
        from .explore import Explorer

        self.check()
        keys = Display(**display)._nodes() if display else {}
        if in_browser is None:
            is_known = page_path() is not None and not any(place.startswith("field") for place in sliders or {})
            in_browser = is_known and not any(isinstance(value, (list, dict)) for value in keys.values())
        page = None
        if in_browser:
            session = self._session(self._resized(list(size)))
            bundle = packed(lambda limit, listener: _barnard.bake(session.scene, limit, False, listener), _LARGEST_VIEW, True)
            page = page_of(bundle).encode()
        return Explorer(self, sliders or {}, size, keys, page)

    def _resized(self, size: list[int]) -> dict[str, Any]:
        """The scene's camera with other pixels, which see as much along a row."""
        return {**self.camera._nodes(), "size": size}


Scene.__init__ = checked(Scene.__init__, "")  # type: ignore[method-assign]
