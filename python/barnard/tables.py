"""Tables of a scene. Keywords are the keys of scene files.

This file is made of the rows that the parser of scene files reads: `python python/write_tables.py` writes it.
Quantities are values of astropy or unyt, or texts with units such as "39000 K". None means unset.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, Union

from numpy.typing import ArrayLike

from ._field import Field, Sampled
from ._table import Table, renamed

#: A value with its unit: of astropy, of unyt, or a text such as "0.4 pc".
Quantity = Union[str, Any]
#: Three lengths: [0.5, 0, -2] * u.pc, or "0.5 0 -2 pc".
Position = Union[str, Sequence[Quantity], Any]
Path = Union[str, os.PathLike]


class Grid(Sampled):
    """3-D array from .npy, .npz, FITS, HDF5 or OpenVDB, trilinear between voxel centres.

    Parameters
    ----------
    file : path
        The file, relative to the scene.
    array : text, default the only one
        Name of the array in an .npz or of the grid in a .vdb, path of the dataset in an HDF5 file, number or EXTNAME
        of the HDU in a FITS file.
    axes : xyz, xzy, yxz, yzx, zxy or zyx, default xyz (npy, npz), zyx (FITS), the file's own (HDF5, vdb)
        Order of the array's axes, slowest first.
    low : position, default from the file, or from voxel
        Lowest corner of the box of the voxels; if the file or voxel defines the box, of the part to read, in whole
        voxels.
    high : position, default from the file, or from voxel
        Highest corner.
    voxel : length, default from low and high
        Edge of a cubic voxel, which defines the box of the whole array.
    scale : length, default none
        Unit of length of files without one, such as .vdb.
    centre : position, default 0 0 0 pc with voxel, otherwise from the file
        Centre of the box of the whole array.
    every : integer between 1 and 1024, default 1
        Number of voxels per axis to average into one; the whole file is never in memory.
    memory : memory size above zero, default none
        Memory limit of the array, met by the smallest sufficient `every`.
    preset : edenhofer24, leike20, lallement22 or vergely22, default none
        Published dust map of the Galaxy, converted to extinction at V in mag/pc (use with scale = "1 mag/pc"); it
        defines array, unit and box, and clips.
    unit : text, default the file's own
        Unit of the values (BUNIT of FITS, units of HDF5): number densities are converted to cm-3, extinctions per
        length to mag/pc; mass densities require mass_per_h; other values are unchanged.
    mass_per_h : number between 1 and 1000, required for mass densities
        Gas mass per hydrogen nucleus in hydrogen masses, to convert mass densities to nuclei per cm3: 1.4 for solar
        abundances.
    wcs : boolean, default true
        Read the file's coordinates (CDELT or CD, CRPIX, CRVAL, CUNIT of FITS, coordinates or edges of HDF5, the
        transform of .vdb); false to use low and high, or voxel.
    storage : single, half or byte, default dense; single for .vdb and arrays above half of the memory limit
        Storage in sparse blocks of 16 x 16 x 16 voxels; half has relative errors of up to 1/2048, byte up to 1/508 of
        the largest value in the block.
    factor : number, default 1
        Factor of all values.
    clip : boolean, default false, true with preset
        Set blank, NaN and negative cells to zero instead of an error.
    copy : boolean, default true
        Copy arrays. Shared arrays become read-only; do not write to older views.

    `file` may be an array in memory with axes x, y, z (or `axes`), of any float or integer type,
    order and stride; units of astropy or unyt are converted.
    Dimensions, uniform coordinates and units of xarray arrays are used.
    Chunks of a Dask array are bricks for `render_bricks`.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "grid"

    def __init__(
        self,
        file: Path | ArrayLike,
        *,
        array: str | None = None,
        axes: Literal["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"] | None = None,
        low: Position | None = None,
        high: Position | None = None,
        voxel: Quantity | None = None,
        scale: Quantity | None = None,
        centre: Position | None = None,
        every: int | None = None,
        memory: Quantity | None = None,
        preset: Literal["edenhofer24", "leike20", "lallement22", "vergely22"] | None = None,
        unit: str | None = None,
        mass_per_h: float | None = None,
        wcs: bool | None = None,
        storage: Literal["single", "half", "byte"] | None = None,
        factor: float | None = None,
        clip: bool | None = None,
        copy: bool = True,
    ):
        self._fill(
            file=file,
            array=array,
            axes=axes,
            low=low,
            high=high,
            voxel=voxel,
            scale=scale,
            centre=centre,
            every=every,
            memory=memory,
            preset=preset,
            unit=unit,
            mass_per_h=mass_per_h,
            wcs=wcs,
            storage=storage,
            factor=factor,
            clip=clip,
            copy=copy,
        )


class Fbm(Field):
    """Fractional Brownian motion of simplex noise (values of about 0 to 1).

    Parameters
    ----------
    seed : integer, default 1
        Seed of the noise.
    centre : position, default 0 0 0 pc
        Centre of the cloud.
    radius : length above zero, default 1 pc
        Radius of the cloud; it fades from half of it on.
    scale : length above zero, default 0.7 pc
        Size of the largest structures.
    octaves : integer between 1 and 12, default 5
        Number of octaves.
    lacunarity : number between 1 and 16, default 2
        Frequency ratio of successive octaves.
    gain : number between 0 and 1, default 0.5
        Amplitude ratio of successive octaves.
    offset : number between -10 and 10, default 0.2
        Offset before clipping at zero; larger values fill more of space.
    variant : plain or ridged, default plain
        Shape of the noise.
    warp : length, default 0 pc
        Strength of domain warping by a second noise.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "fbm"

    def __init__(
        self,
        *,
        seed: int | None = None,
        centre: Position | None = None,
        radius: Quantity | None = None,
        scale: Quantity | None = None,
        octaves: int | None = None,
        lacunarity: float | None = None,
        gain: float | None = None,
        offset: float | None = None,
        variant: Literal["plain", "ridged"] | None = None,
        warp: Quantity | None = None,
    ):
        self._fill(
            seed=seed,
            centre=centre,
            radius=radius,
            scale=scale,
            octaves=octaves,
            lacunarity=lacunarity,
            gain=gain,
            offset=offset,
            variant=variant,
            warp=warp,
        )


class Sphere(Field):
    """1 inside of a sphere.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Centre of the sphere.
    radius : length above zero
        Radius of the sphere.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "sphere"

    def __init__(self, radius: Quantity, *, centre: Position | None = None):
        self._fill(centre=centre, radius=radius)


class Box(Field):
    """1 inside an axis-aligned box.

    Parameters
    ----------
    low : position
        Lowest corner.
    high : position
        Highest corner.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "box"

    def __init__(self, low: Position, high: Position):
        self._fill(low=low, high=high)


class Plummer(Field):
    """(1 + r2/a2)^(-5/2), cut at a radius.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Centre of the cluster.
    core : length above zero
        The Plummer radius a.
    cut : length above zero, default 5 core
        Radius beyond which it is zero.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "plummer"

    def __init__(self, core: Quantity, *, centre: Position | None = None, cut: Quantity | None = None):
        self._fill(centre=centre, core=core, cut=cut)


class Shell(Field):
    """A spherical shell with a Gaussian wall.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Centre of the shell.
    radius : length above zero
        Radius of the wall, whose density is 1; a growing shell keeps its mass if `scale` decreases with radius²
        thickness.
    thickness : length above zero
        Standard deviation of the wall.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "shell"

    def __init__(self, radius: Quantity, thickness: Quantity, *, centre: Position | None = None):
        self._fill(centre=centre, radius=radius, thickness=thickness)


class Slab(Field):
    """1 between two planes of any orientation, within a cube.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Centre of the cube, on the middle plane.
    normal : direction, default [0, 0, 1]
        Normal of the planes.
    thickness : length above zero
        Distance of the planes.
    extent : length above zero
        Half edge of the bounding cube.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "slab"

    def __init__(
        self,
        thickness: Quantity,
        extent: Quantity,
        *,
        centre: Position | None = None,
        normal: Sequence[float] | None = None,
    ):
        self._fill(centre=centre, normal=normal, thickness=thickness, extent=extent)


class Turbulence(Field):
    """Lognormal density of supersonic turbulence in a box, with mean 1, on voxels.

    Parameters
    ----------
    seed : integer, default 1
        Seed of the random waves.
    low : position, default -1 -1 -1 pc
        Lower corner of the box; the field is periodic in it.
    high : position, default 1 1 1 pc
        Upper corner of the box.
    voxels : integer between 8 and 2048, default 128
        Voxels along the longest edge; more voxels add finer waves and keep the others.
    outer_scale : length above zero, default half of the shortest edge
        Driving scale of turbulence; larger waves are not stronger.
    mach : number between 0 and 1000, default 5
        Rms Mach number M; 0 is uniform.
    forcing : solenoidal, mixed or compressive, default mixed
        Driving of the turbulence: b = 1/3, 0.4 or 1 in σ² = ln(1 + b² M²).
    plasma_beta : number between 1e-6 and 1e6, default no magnetic field
        Thermal over magnetic pressure.
    slope : number between 3.05 and 8, default 3.66666667
        n of the spectrum k^-n of ln ρ in three dimensions: 3.6 to 4.3 in simulations (Federrath et al. 2010).

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "turbulence"

    def __init__(
        self,
        *,
        seed: int | None = None,
        low: Position | None = None,
        high: Position | None = None,
        voxels: int | None = None,
        outer_scale: Quantity | None = None,
        mach: float | None = None,
        forcing: Literal["solenoidal", "mixed", "compressive"] | None = None,
        plasma_beta: float | None = None,
        slope: float | None = None,
    ):
        self._fill(
            seed=seed,
            low=low,
            high=high,
            voxels=voxels,
            outer_scale=outer_scale,
            mach=mach,
            forcing=forcing,
            plasma_beta=plasma_beta,
            slope=slope,
        )


class Expression(Field):
    """Expression of other fields, shared by several densities.

    Parameters
    ----------
    formula : expression
        Expression of other fields, such as "cloud * (1 - hole)"; the order is free, and they may be expressions
        themselves.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "field.*"
    _kind = "expression"

    def __init__(self, formula: str):
        self._fill(formula=formula)


class Stereo(Table):
    """Stereo: off-axis pairs in flat images, omni-directional stereo in 360° images. One image contains both eyes.

    Parameters
    ----------
    eye_distance : length above zero
        Distance of the eyes; 1/30 of the distance to the object is deep, 1/100 shallow.
    convergence : length above zero, default to the target
        Distance of the screen plane; nearer objects appear in front of it.
    arrangement : over_under or side_by_side, default over_under
        over_under has the left eye on top; `%V` in an output name writes a file per eye.
    pole_merge : list of angles, default ["60 deg", "75 deg"]
        In 360° images, altitudes between which both eyes merge.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera.stereo"

    def __init__(
        self,
        eye_distance: Quantity,
        *,
        convergence: Quantity | None = None,
        arrangement: Literal["over_under", "side_by_side"] | None = None,
        pole_merge: Sequence[Quantity] | Quantity | None = None,
    ):
        self._fill(eye_distance=eye_distance, convergence=convergence, arrangement=arrangement, pole_merge=pole_merge)


class Keyframe(Table):
    """A keyframe of the camera, with only the values that it sets. In files these are columns, with units in brackets:
    `time [s]`, then `x [pc]`, `y [pc]` and `z [pc]`, `target_x` or `direction_x` or `orientation_x` to
    `orientation_w`, `up_x` and so on, and `field_of_view [deg]`.

    Parameters
    ----------
    time : time
        Time of the keyframe.
    position : position, default interpolated
        Position of the observer.
    target : position, default interpolated
        Target of the view.
    direction : list of numbers, default towards the target
        Viewing direction, instead of a target.
    orientation : list of numbers, default towards the target
        Quaternion [x, y, z, w] that rotates a camera looking along -z with y up, instead of target and up.
    up : list of numbers, default interpolated
        Up direction of the image.
    field_of_view : angle, default interpolated
        Horizontal field of view, of a perspective camera.
    width : length, default interpolated
        Width of the image, of an orthographic camera.
    aperture : angle, default interpolated
        Angle across the circle, of a fisheye.
    tilt : angle, default interpolated
        Tilt of a fisheye's centre from up towards the target.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera.path.key"

    def __init__(
        self,
        time: Quantity,
        *,
        position: Position | None = None,
        target: Position | None = None,
        direction: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        up: Sequence[float] | None = None,
        field_of_view: Quantity | None = None,
        width: Quantity | None = None,
        aperture: Quantity | None = None,
        tilt: Quantity | None = None,
    ):
        self._fill(
            time=time,
            position=position,
            target=target,
            direction=direction,
            orientation=orientation,
            up=up,
            field_of_view=field_of_view,
            width=width,
            aperture=aperture,
            tilt=tilt,
        )


class CameraPath(Table):
    """Camera path: keyframes, or a path from another program. Without a requested frame, a scene shows its first moment.

    Parameters
    ----------
    key : list of tables, default none
        Two or more keyframes, [[camera.path.key]], unless a file is given.
    file : path, default none
        File of keyframes: CSV, Gaia Sky camera path (.gsc), or the first animated camera of a glTF (.gltf, .glb).
    unit : length above zero, default 1 pc
        Unit of length of a .gltf or .glb, and of CSV columns without a unit.
    interpolation : catmull_rom, bezier, linear or step, default catmull_rom
        Interpolation between keyframes.
    ease : time, default 0 s
        Time to accelerate from rest at the beginning, and to decelerate at the end.
    constant_speed : boolean, default false
        Constant speed; only the times of the first and last key are used.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera.path"

    def __init__(
        self,
        *,
        key: Sequence[Keyframe | dict[str, Any]] | None = None,
        file: Path | None = None,
        unit: Quantity | None = None,
        interpolation: Literal["catmull_rom", "bezier", "linear", "step"] | None = None,
        ease: Quantity | None = None,
        constant_speed: bool | None = None,
    ):
        self._fill(
            key=key,
            file=file,
            unit=unit,
            interpolation=interpolation,
            ease=ease,
            constant_speed=constant_speed,
        )


class Camera(Table):
    """The observer's camera; `kind` selects the projection.

    Kinds
    -----
    perspective
        All rays from one point.
    orthographic
        Parallel rays, starting on the image plane.
    fisheye
        Dome master: equidistant, black outside of the circle, front of the audience at the bottom.
    equirectangular
        360° image, longitude by latitude, target in the centre; twice as wide as high.
    cubemap
        360° image, six faces of a cube above each other, as in OpenEXR environment maps; six times as high as wide.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].
    field_of_view : angle above zero and below 180 deg
        Horizontal field of view. Of kind perspective, required there.
    width : length above zero
        Width of the image. Of kind orthographic, required there.
    aperture : angle above zero and at most 360 deg
        Angle across the circle. Of kind fisheye.
    tilt : angle between 0 and 180 deg
        Tilt of the image centre from up towards the target, at 90 deg the target is in the centre. Of kind fisheye.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"

    def __init__(
        self,
        kind: Literal["perspective", "orthographic", "fisheye", "equirectangular", "cubemap"],
        position: Position,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
        field_of_view: Quantity | None = None,
        width: Quantity | None = None,
        aperture: Quantity | None = None,
        tilt: Quantity | None = None,
    ):
        self._fill(
            kind=kind,
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
            field_of_view=field_of_view,
            width=width,
            aperture=aperture,
            tilt=tilt,
        )


class PerspectiveCamera(Camera):
    """All rays from one point.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].
    field_of_view : angle above zero and below 180 deg
        Horizontal field of view.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"
    _kind = "perspective"

    def __init__(
        self,
        position: Position,
        field_of_view: Quantity,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
    ):
        self._fill(
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
            field_of_view=field_of_view,
        )


perspective = renamed("perspective", PerspectiveCamera)


class OrthographicCamera(Camera):
    """Parallel rays, starting on the image plane.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].
    width : length above zero
        Width of the image.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"
    _kind = "orthographic"

    def __init__(
        self,
        position: Position,
        width: Quantity,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
    ):
        self._fill(
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
            width=width,
        )


orthographic = renamed("orthographic", OrthographicCamera)


class FisheyeCamera(Camera):
    """Dome master: equidistant, black outside of the circle, front of the audience at the bottom.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].
    aperture : angle above zero and at most 360 deg, default 180 deg
        Angle across the circle.
    tilt : angle between 0 and 180 deg, default 0 deg
        Tilt of the image centre from up towards the target, at 90 deg the target is in the centre.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"
    _kind = "fisheye"

    def __init__(
        self,
        position: Position,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
        aperture: Quantity | None = None,
        tilt: Quantity | None = None,
    ):
        self._fill(
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
            aperture=aperture,
            tilt=tilt,
        )


fisheye = renamed("fisheye", FisheyeCamera)


class EquirectangularCamera(Camera):
    """360° image, longitude by latitude, target in the centre; twice as wide as high.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"
    _kind = "equirectangular"

    def __init__(
        self,
        position: Position,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
    ):
        self._fill(
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
        )


equirectangular = renamed("equirectangular", EquirectangularCamera)


class CubemapCamera(Camera):
    """360° image, six faces of a cube above each other, as in OpenEXR environment maps; six times as high as wide.

    Parameters
    ----------
    position : position
        Position of the observer.
    target : position, default 0 0 0 pc
        Target of the view.
    up : direction, default [0, 1, 0]
        Up direction of the image.
    size : [width, height], each above zero and at most 65536, default [512, 512]
        Pixels of the image.
    crop : list of numbers, each at least zero, default the whole image
        [column, row, width, height] of the rendered part, in pixels from the upper left corner.
    supersampling : integer between 1 and 16, default 1
        Rays per pixel edge.
    stereo : table, default one eye
        Stereo, [camera.stereo].
    path : table, default a static camera
        Camera path, [camera.path].

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "camera"
    _kind = "cubemap"

    def __init__(
        self,
        position: Position,
        *,
        target: Position | None = None,
        up: Sequence[float] | None = None,
        size: int | Sequence[int] | None = None,
        crop: Sequence[float] | None = None,
        supersampling: int | None = None,
        stereo: Stereo | None = None,
        path: CameraPath | None = None,
    ):
        self._fill(
            position=position,
            target=target,
            up=up,
            size=size,
            crop=crop,
            supersampling=supersampling,
            stereo=stereo,
            path=path,
        )


cubemap = renamed("cubemap", CubemapCamera)


class Albedo(Table):
    """The scattered fraction of extinction.

    Kinds
    -----
    constant
        Constant over wavelength; short form: albedo = 0.6.
    linear
        Value + slope (lambda - at)/100 nm, clipped to 0 to 1.
    file
        From a file of wavelength and albedo.

    Parameters
    ----------
    value : number between 0 and 1
        Albedo at the wavelength `at`. Of kind constant, linear, required there.
    slope : number between -1 and 1
        Change per 100 nm. Of kind linear.
    at : wavelength above zero
        Wavelength of the value. Of kind linear.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and albedo. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.albedo"

    def __init__(
        self,
        kind: Literal["constant", "linear", "file"],
        *,
        value: float | None = None,
        slope: float | None = None,
        at: Quantity | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(kind=kind, value=value, slope=slope, at=at, file=file, unit=unit, column=column)


class ConstantAlbedo(Albedo):
    """Constant over wavelength; short form: albedo = 0.6.

    Parameters
    ----------
    value : number between 0 and 1
        The albedo.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.albedo"
    _kind = "constant"

    def __init__(self, value: float):
        self._fill(value=value)


class LinearAlbedo(Albedo):
    """Value + slope (lambda - at)/100 nm, clipped to 0 to 1.

    Parameters
    ----------
    value : number between 0 and 1
        Albedo at the wavelength `at`.
    slope : number between -1 and 1, default 0
        Change per 100 nm.
    at : wavelength above zero, default 550 nm
        Wavelength of the value.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.albedo"
    _kind = "linear"

    def __init__(self, value: float, *, slope: float | None = None, at: Quantity | None = None):
        self._fill(value=value, slope=slope, at=at)


class FileAlbedo(Albedo):
    """From a file of wavelength and albedo.

    Parameters
    ----------
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and albedo.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.albedo"
    _kind = "file"

    def __init__(self, file: Path, *, unit: str | None = None, column: str | None = None):
        self._fill(file=file, unit=unit, column=column)


class Phase(Table):
    """Angular distribution of scattered light; cos θ = +1 is forward.

    Kinds
    -----
    isotropic
        The same in all directions.
    henyey_greenstein
        Henyey & Greenstein 1941 with mean cosine g(lambda).
    draine
        Draine 2003 with g(lambda) and alpha: between Rayleigh and Henyey-Greenstein.
    rayleigh
        3/16pi (1 + cos2): small grains.
    tabulated
        From a CSV of cos theta and p for one or more wavelengths.

    Parameters
    ----------
    g : number between -0.999 and 0.999
        Shape parameter. Of kind henyey_greenstein, draine.
    g_file : path
        Text, ECSV, VOTable or FITS table of wavelength and g. Of kind henyey_greenstein, draine.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind
        henyey_greenstein, draine.
    column : text
        Name or number of the file's column to read. Of kind henyey_greenstein, draine.
    alpha : number between 0 and 1000
        0 is Henyey-Greenstein, 1 with g = 0 is Rayleigh. Of kind draine.
    file : path
        The CSV. Of kind tabulated, required there.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"

    def __init__(
        self,
        kind: Literal["isotropic", "henyey_greenstein", "draine", "rayleigh", "tabulated"],
        *,
        g: float | None = None,
        g_file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
        alpha: float | None = None,
        file: Path | None = None,
    ):
        self._fill(kind=kind, g=g, g_file=g_file, unit=unit, column=column, alpha=alpha, file=file)


class IsotropicPhase(Phase):
    """The same in all directions.


    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"
    _kind = "isotropic"

    def __init__(self):
        self._fill()


class HenyeyGreensteinPhase(Phase):
    """Henyey & Greenstein 1941 with mean cosine g(lambda).

    Parameters
    ----------
    g : number between -0.999 and 0.999, default the law's own
        Mean cosine.
    g_file : path, default none
        Text, ECSV, VOTable or FITS table of wavelength and g.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"
    _kind = "henyey_greenstein"

    def __init__(
        self,
        *,
        g: float | None = None,
        g_file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(g=g, g_file=g_file, unit=unit, column=column)


class DrainePhase(Phase):
    """Draine 2003 with g(lambda) and alpha: between Rayleigh and Henyey-Greenstein.

    Parameters
    ----------
    g : number between -0.999 and 0.999, default the law's own
        Shape parameter.
    g_file : path, default none
        Text, ECSV, VOTable or FITS table of wavelength and g.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.
    alpha : number between 0 and 1000, default 1
        0 is Henyey-Greenstein, 1 with g = 0 is Rayleigh.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"
    _kind = "draine"

    def __init__(
        self,
        *,
        g: float | None = None,
        g_file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
        alpha: float | None = None,
    ):
        self._fill(g=g, g_file=g_file, unit=unit, column=column, alpha=alpha)


class RayleighPhase(Phase):
    """3/16pi (1 + cos2): small grains.


    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"
    _kind = "rayleigh"

    def __init__(self):
        self._fill()


class TabulatedPhase(Phase):
    """From a CSV of cos theta and p for one or more wavelengths.

    Parameters
    ----------
    file : path
        The CSV.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust.phase"
    _kind = "tabulated"

    def __init__(self, file: Path):
        self._fill(file=file)


class Dust(Table):
    """Dust that absorbs and scatters.

    Parameters
    ----------
    density : expression
        Density, an expression of fields such as "cloud" or "n_H * (1 - x_ion)".
    scale : extinction at least zero
        Extinction at density 1: per length (A_V of "2 mag/pc", depth of "4 /pc"), or for a density in cm-3 per
        hydrogen column ("5.32e-22 mag cm2") or mass column ("200 cm2/g", with mass_per_h).
    mass_per_h : number between 1 and 1000, required for a scale per mass
        Mass per hydrogen nucleus in hydrogen masses, for a scale per gram: 1.4 for all of the gas.
    law : text, default draine03_rv31
        Extinction law.
    r_v : number between 0 and 100, default 3.1
        A(V)/E(B-V), for laws with this parameter.
    albedo : number or table between 0 and 1, default albedo of the law's grains
        Scattered fraction of extinction; Milky Way laws without grains use Draine 2003 of the nearest R_V.
    phase : table, default isotropic
        Angular distribution of scattered light.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "dust"

    def __init__(
        self,
        density: str,
        scale: Quantity,
        *,
        mass_per_h: float | None = None,
        law: str | None = None,
        r_v: float | None = None,
        albedo: float | Albedo | None = None,
        phase: Phase | None = None,
    ):
        self._fill(density=density, scale=scale, mass_per_h=mass_per_h, law=law, r_v=r_v, albedo=albedo, phase=phase)


class Star(Table):
    """A star; `kind` selects the shape of its spectrum, and exactly one scale its brightness.

    Kinds
    -----
    blackbody
        Planck function of a temperature.
    stellar
        Spectrum of a spectral type (library of Pickles 1998, interpolated between types).
    atmosphere
        Model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K).
    power_law
        (lambda/reference)^exponent.
    file
        From a file of wavelength and flux.

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    temperature : temperature above zero
        Effective temperature, 10000 to 50000 K. Of kind blackbody, atmosphere, required there.
    type : text
        Spectral type in the catalogue `stars`, such as "O9.5V" or "K0 III". Of kind stellar, required there.
    log_g : number between -1 and 9
        Surface gravity, log10 of cm s-2; hotter stars require higher values. Of kind atmosphere.
    exponent : number between -50 and 50
        Exponent in wavelength. Of kind power_law, required there.
    reference : wavelength above zero
        Wavelength of strength 1. Of kind power_law.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"

    def __init__(
        self,
        position: Position,
        *,
        kind: Literal["blackbody", "stellar", "atmosphere", "power_law", "file"] = "blackbody",
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
        temperature: Quantity | None = None,
        type: str | None = None,
        log_g: float | None = None,
        exponent: float | None = None,
        reference: Quantity | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            kind=kind,
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            temperature=temperature,
            type=type,
            log_g=log_g,
            exponent=exponent,
            reference=reference,
            file=file,
            unit=unit,
            column=column,
        )


class BlackbodyStar(Star):
    """Planck function of a temperature.

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    temperature : temperature between 1 and 1e9 K
        Effective temperature.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"
    _kind = "blackbody"

    def __init__(
        self,
        position: Position,
        temperature: Quantity,
        *,
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
    ):
        self._fill(
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            temperature=temperature,
        )


class StellarStar(Star):
    """Spectrum of a spectral type (library of Pickles 1998, interpolated between types).

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    type : text
        Spectral type in the catalogue `stars`, such as "O9.5V" or "K0 III".

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"
    _kind = "stellar"

    def __init__(
        self,
        position: Position,
        type: str,
        *,
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
    ):
        self._fill(
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            type=type,
        )


class AtmosphereStar(Star):
    """Model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K).

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    temperature : temperature above zero
        Effective temperature, 10000 to 50000 K.
    log_g : number between -1 and 9, default 4.5
        Surface gravity, log10 of cm s-2; hotter stars require higher values.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"
    _kind = "atmosphere"

    def __init__(
        self,
        position: Position,
        temperature: Quantity,
        *,
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
        log_g: float | None = None,
    ):
        self._fill(
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            temperature=temperature,
            log_g=log_g,
        )


class PowerLawStar(Star):
    """(lambda/reference)^exponent.

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    exponent : number between -50 and 50
        Exponent in wavelength.
    reference : wavelength above zero, default 550 nm
        Wavelength of strength 1.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"
    _kind = "power_law"

    def __init__(
        self,
        position: Position,
        exponent: float,
        *,
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
        reference: Quantity | None = None,
    ):
        self._fill(
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            exponent=exponent,
            reference=reference,
        )


class FileStar(Star):
    """From a file of wavelength and flux.

    Parameters
    ----------
    name : text, default star N
        Its name.
    position : position
        Where it is.
    visible : boolean, default true
        Draw the star itself as an unresolved source.
    luminosity : luminosity above zero, exactly one scale is required
        Bolometric luminosity.
    radius : length above zero, exactly one scale is required
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity above zero, exactly one scale is required
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of spectral_luminosity.
    magnitude : magnitude, exactly one scale is required
        Apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`.
    extinction : magnitude at least zero, default 0 mag
        A_V between the star and the observer of its magnitude; it is removed.
    extinction_law : text, default gordon23
        Extinction law of that dust, with R_V = 3.1 where it applies.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length above zero, required with magnitude
        Distance of the observer of the magnitude.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star"
    _kind = "file"

    def __init__(
        self,
        position: Position,
        file: Path,
        *,
        name: str | None = None,
        visible: bool | None = None,
        luminosity: Quantity | None = None,
        radius: Quantity | None = None,
        spectral_luminosity: Quantity | None = None,
        wavelength: Quantity | None = None,
        magnitude: Quantity | None = None,
        extinction: Quantity | None = None,
        extinction_law: str | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            name=name,
            position=position,
            visible=visible,
            luminosity=luminosity,
            radius=radius,
            spectral_luminosity=spectral_luminosity,
            wavelength=wavelength,
            magnitude=magnitude,
            extinction=extinction,
            extinction_law=extinction_law,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
            file=file,
            unit=unit,
            column=column,
        )


class StarTable(Table):
    """Stars of a CSV file, one per row. Columns have the names of [[star]] keys, with x, y and z for `position`; units
    may follow the name, as in `temperature [K]`, or, except for positions, be in the cell. Defaults are pc for
    lengths, Rsun for radii, K, Lsun and mag. Empty cells and other columns are ignored. Any key of [[star]] next to
    `file` applies to all stars. `kind` is "stellar" if there is a column `type`, "blackbody" otherwise. Separators
    are commas, semicolons, tabs or blanks; lines that begin with `#` are skipped.

    Parameters
    ----------
    file : path
        CSV file with a header and one star per row.
    columns : text or list of texts, default all keys of [[star]]
        Columns to read in addition to x, y and z.
    visible : boolean, default true
        Draw the stars themselves.
    magnitude_band : text, default johnson-V
        Embedded passband of a magnitude column.
    distance : length above zero, required for magnitudes
        Distance of the observer of the magnitudes.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "star_table"

    def __init__(
        self,
        file: Path,
        *,
        columns: str | Sequence[str] | None = None,
        visible: bool | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
    ):
        self._fill(
            file=file,
            columns=columns,
            visible=visible,
            magnitude_band=magnitude_band,
            distance=distance,
            magnitude_system=magnitude_system,
        )


class Emission(Table):
    """Gas that glows.

    Kinds
    -----
    lines
        Lines of given strengths, with or without a power-law continuum.
    ion
        All lines of an ion from its emissivities; the density is n_e n_H in cm-6.
    recombination
        Hydrogen continuum (free-bound, free-free, two-photon); the density is n_e n_H+ in cm-6.
    line_list
        A model nebula's lines relative to H-beta.
    file
        A tabulated spectrum.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    scale : emission coefficient above zero
        Emission coefficient at density 1 and spectral strength 1, such as "1e-25 W/m3/sr". Of kind lines, line_list,
        file, required there.
    lines : list of tables
        { wavelength = "656.46 nm", strength = 3 }, wavelength in vacuum, strength integrated over the line. Of kind
        lines, required there.
    continuum : number at least zero
        Strength per nm at `continuum_at`. Of kind lines.
    continuum_at : wavelength above zero
        Wavelength of that strength. Of kind lines.
    continuum_exponent : number between -50 and 50
        Exponent of the continuum in wavelength. Of kind lines.
    ion : text
        Name in the catalogue `ions`, such as "H1", "O3", "N2", "S2". Of kind ion, required there.
    temperature : temperature above zero
        Electron temperature, 6000 to 15000 K. Of kind ion, recombination, required there.
    electron_density : number density above zero
        100 to 1e4 cm-3. Of kind ion, recombination, required there.
    abundance : number between 0 and 1000
        n_ion / n_H. Of kind ion.
    list : text
        Name in the catalogue `line-lists`. Of kind line_list, required there.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and strength per nm. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"

    def __init__(
        self,
        kind: Literal["lines", "ion", "recombination", "line_list", "file"],
        density: str,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
        scale: Quantity | None = None,
        lines: Sequence[dict[str, Any]] | None = None,
        continuum: float | None = None,
        continuum_at: Quantity | None = None,
        continuum_exponent: float | None = None,
        ion: str | None = None,
        temperature: Quantity | None = None,
        electron_density: Quantity | None = None,
        abundance: float | None = None,
        list: str | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            kind=kind,
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            scale=scale,
            lines=lines,
            continuum=continuum,
            continuum_at=continuum_at,
            continuum_exponent=continuum_exponent,
            ion=ion,
            temperature=temperature,
            electron_density=electron_density,
            abundance=abundance,
            list=list,
            file=file,
            unit=unit,
            column=column,
        )


class LinesEmission(Emission):
    """Lines of given strengths, with or without a power-law continuum.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    scale : emission coefficient above zero
        Emission coefficient at density 1 and spectral strength 1, such as "1e-25 W/m3/sr".
    lines : list of tables
        { wavelength = "656.46 nm", strength = 3 }, wavelength in vacuum, strength integrated over the line.
    continuum : number at least zero, default 0
        Strength per nm at `continuum_at`.
    continuum_at : wavelength above zero, default 550 nm
        Wavelength of that strength.
    continuum_exponent : number between -50 and 50, default 0
        Exponent of the continuum in wavelength.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"
    _kind = "lines"

    def __init__(
        self,
        density: str,
        scale: Quantity,
        lines: Sequence[dict[str, Any]],
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
        continuum: float | None = None,
        continuum_at: Quantity | None = None,
        continuum_exponent: float | None = None,
    ):
        self._fill(
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            scale=scale,
            lines=lines,
            continuum=continuum,
            continuum_at=continuum_at,
            continuum_exponent=continuum_exponent,
        )


class IonEmission(Emission):
    """All lines of an ion from its emissivities; the density is n_e n_H in cm-6.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    ion : text
        Name in the catalogue `ions`, such as "H1", "O3", "N2", "S2".
    temperature : temperature above zero
        Electron temperature, 5000 to 20000 K.
    electron_density : number density above zero
        Electron density for collisional de-excitation, 10 to 1e5 cm-3.
    abundance : number between 0 and 1000, default 1
        n_ion / n_H.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"
    _kind = "ion"

    def __init__(
        self,
        density: str,
        ion: str,
        temperature: Quantity,
        electron_density: Quantity,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
        abundance: float | None = None,
    ):
        self._fill(
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            ion=ion,
            temperature=temperature,
            electron_density=electron_density,
            abundance=abundance,
        )


class RecombinationEmission(Emission):
    """Hydrogen continuum (free-bound, free-free, two-photon); the density is n_e n_H+ in cm-6.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    temperature : temperature above zero
        Electron temperature, 6000 to 15000 K.
    electron_density : number density above zero
        100 to 1e4 cm-3.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"
    _kind = "recombination"

    def __init__(
        self,
        density: str,
        temperature: Quantity,
        electron_density: Quantity,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
    ):
        self._fill(
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            temperature=temperature,
            electron_density=electron_density,
        )


class LineListEmission(Emission):
    """A model nebula's lines relative to H-beta.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    scale : emission coefficient above zero
        Emission coefficient at density 1 and spectral strength 1, such as "1e-25 W/m3/sr".
    list : text
        Name in the catalogue `line-lists`.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"
    _kind = "line_list"

    def __init__(
        self,
        density: str,
        scale: Quantity,
        list: str,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
    ):
        self._fill(
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            scale=scale,
            list=list,
        )


class FileEmission(Emission):
    """A tabulated spectrum.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Density, an expression of fields such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Full width at half maximum of the lines.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.
    scale : emission coefficient above zero
        Emission coefficient at density 1 and spectral strength 1, such as "1e-25 W/m3/sr".
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and strength per nm.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "emission"
    _kind = "file"

    def __init__(
        self,
        density: str,
        scale: Quantity,
        file: Path,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            name=name,
            density=density,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
            scale=scale,
            file=file,
            unit=unit,
            column=column,
        )


class Gas(Table):
    """Gas ionised by the scene's stars: ionisation, temperature and emission lines follow from its density and the stars
    ([docs/gas.md](gas.md)).

    Parameters
    ----------
    density : expression
        Hydrogen nuclei in cm-3, an expression of fields such as "n_H".
    abundances : text or list of numbers at least zero, default orion
        Orion, solar, lmc or hii40, or He, C, N, O, Ne, Mg, Si and S per hydrogen nucleus; six numbers omit Mg and Si.
    voxels : integer between 8 and 2048, default those of the grid; 96 for a function
        Voxels along the longest edge; more than those of the grid make fronts finer.
    dust_absorption : number between 0 and 1e-15, default 0
        Cross section of dust for ionising light in cm2 per hydrogen nucleus, such as 1e-21.
    temperature : temperature between 500 and 60000 K, default thermal equilibrium
        Fixed electron temperature.
    diffuse : outward or on_the_spot, default outward
        Treatment of recombination light: outward (transported along the stars' rays) or on_the_spot (absorbed where
        it is emitted).
    doppler_fwhm : velocity at least zero and below 29979.2458 km/s, default 0 km/s
        Turbulent full width at half maximum of the lines; the thermal width, 19 km/s for hydrogen at 8000 K, is added
        in quadrature.
    velocity : text or list of texts, default at rest
        Velocity along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]; lines are
        Doppler-shifted as seen from the scene's camera.
    velocity_step : velocity above zero, default 10 km/s
        Velocity resolution; use half of a channel or less.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "gas"

    def __init__(
        self,
        density: str,
        *,
        abundances: str | Sequence[float] | None = None,
        voxels: int | None = None,
        dust_absorption: float | None = None,
        temperature: Quantity | None = None,
        diffuse: Literal["outward", "on_the_spot"] | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: str | Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
    ):
        self._fill(
            density=density,
            abundances=abundances,
            voxels=voxels,
            dust_absorption=dust_absorption,
            temperature=temperature,
            diffuse=diffuse,
            doppler_fwhm=doppler_fwhm,
            velocity=velocity,
            velocity_step=velocity_step,
        )


class StarField(Table):
    """Stars at infinity, the same from every camera. A picture shows the brightest 100 000 in view, or one per two
    pixels if that is more.

    Parameters
    ----------
    seed : integer, default 1
        Seed of the random field.
    density : density on the sky above zero, default 2000 /deg2
        Stars per solid angle.
    brightest : number between -30 and 40, default 8
        V magnitude (Vega) of the brightest.
    faintest : number between -30 and 40, default 18
        V magnitude (Vega) of the faintest; counts grow as 10^(0.4 m).

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background.stars"

    def __init__(
        self,
        *,
        seed: int | None = None,
        density: Quantity | None = None,
        brightest: float | None = None,
        faintest: float | None = None,
    ):
        self._fill(seed=seed, density=density, brightest=brightest, faintest=faintest)


class StarCatalogue(Table):
    """Stars of a CSV file at infinity, at their sky positions. Columns: `ra` and `dec`, or `glon` and `glat` (numbers in
    degrees, or texts such as 18h18m48s), `magnitude` or the name of a passband (`johnson-V`; or Gaia's
    `phot_g_mean_mag`, `phot_bp_mean_mag`, `phot_rp_mean_mag`), a second magnitude, `temperature` or `type` for the
    colour, and `name`; other columns and rows without a magnitude are ignored. A star with two magnitudes has exactly
    both.

    Parameters
    ----------
    file : path
        CSV file with a header and one star per row.
    axes : observation, icrs or galactic, default observation
        Orientation of the sky. observation: as [observation] places each image, for any camera position; icrs or
        galactic: the scene's axes are those of the sky.
    magnitude_band : text, default johnson-V
        Embedded passband of a column `magnitude`.
    magnitude_system : vega or ab, default vega; required for passbands without conventional Vega magnitudes
        Zero point of magnitudes.
    temperature : temperature above zero, default 5800 K
        Temperature of stars without type, temperature or second magnitude.
    epoch : number between 1700 and 2300, default that of the catalogue
        Year to which proper motions (columns pmra and pmdec, mas/yr) are applied, such as 2026.5.
    catalogue_epoch : number between 1700 and 2300, default column ref_epoch; 2000 for HYG
        Year of the positions.
    faintest : number between -30 and 40, default none
        Limiting magnitude; fainter stars are skipped.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background.catalogue"

    def __init__(
        self,
        file: Path,
        *,
        axes: Literal["observation", "icrs", "galactic"] | None = None,
        magnitude_band: str | None = None,
        magnitude_system: Literal["vega", "ab"] | None = None,
        temperature: Quantity | None = None,
        epoch: float | None = None,
        catalogue_epoch: float | None = None,
        faintest: float | None = None,
    ):
        self._fill(
            file=file,
            axes=axes,
            magnitude_band=magnitude_band,
            magnitude_system=magnitude_system,
            temperature=temperature,
            epoch=epoch,
            catalogue_epoch=catalogue_epoch,
            faintest=faintest,
        )


class Background(Table):
    """Background of the cloud: with a `kind` (the spectra of stars, above) a uniform light, with `[background.stars]` a
    field of stars.

    Kinds
    -----
    blackbody
        Planck function of a temperature.
    stellar
        Spectrum of a spectral type (library of Pickles 1998, interpolated between types).
    atmosphere
        Model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K).
    power_law
        (lambda/reference)^exponent.
    file
        From a file of wavelength and flux.

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    temperature : temperature above zero
        Effective temperature, 10000 to 50000 K. Of kind blackbody, atmosphere, required there.
    type : text
        Spectral type in the catalogue `stars`, such as "O9.5V" or "K0 III". Of kind stellar, required there.
    log_g : number between -1 and 9
        Surface gravity, log10 of cm s-2; hotter stars require higher values. Of kind atmosphere.
    exponent : number between -50 and 50
        Exponent in wavelength. Of kind power_law, required there.
    reference : wavelength above zero
        Wavelength of strength 1. Of kind power_law.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"

    def __init__(
        self,
        *,
        kind: Literal["blackbody", "stellar", "atmosphere", "power_law", "file"] | None = None,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        temperature: Quantity | None = None,
        type: str | None = None,
        log_g: float | None = None,
        exponent: float | None = None,
        reference: Quantity | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            kind=kind,
            radiance=radiance,
            wavelength=wavelength,
            stars=stars,
            catalogue=catalogue,
            temperature=temperature,
            type=type,
            log_g=log_g,
            exponent=exponent,
            reference=reference,
            file=file,
            unit=unit,
            column=column,
        )


class BlackbodyBackground(Background):
    """Planck function of a temperature.

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    temperature : temperature between 1 and 1e9 K
        Effective temperature.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"
    _kind = "blackbody"

    def __init__(
        self,
        *,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        temperature: Quantity | None = None,
    ):
        self._fill(
            radiance=radiance,
            wavelength=wavelength,
            stars=stars,
            catalogue=catalogue,
            temperature=temperature,
        )


class StellarBackground(Background):
    """Spectrum of a spectral type (library of Pickles 1998, interpolated between types).

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    type : text
        Spectral type in the catalogue `stars`, such as "O9.5V" or "K0 III".

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"
    _kind = "stellar"

    def __init__(
        self,
        *,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        type: str | None = None,
    ):
        self._fill(radiance=radiance, wavelength=wavelength, stars=stars, catalogue=catalogue, type=type)


class AtmosphereBackground(Background):
    """Model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K).

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    temperature : temperature above zero
        Effective temperature, 10000 to 50000 K.
    log_g : number between -1 and 9, default 4.5
        Surface gravity, log10 of cm s-2; hotter stars require higher values.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"
    _kind = "atmosphere"

    def __init__(
        self,
        *,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        temperature: Quantity | None = None,
        log_g: float | None = None,
    ):
        self._fill(
            radiance=radiance,
            wavelength=wavelength,
            stars=stars,
            catalogue=catalogue,
            temperature=temperature,
            log_g=log_g,
        )


class PowerLawBackground(Background):
    """(lambda/reference)^exponent.

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    exponent : number between -50 and 50
        Exponent in wavelength.
    reference : wavelength above zero, default 550 nm
        Wavelength of strength 1.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"
    _kind = "power_law"

    def __init__(
        self,
        *,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        exponent: float | None = None,
        reference: Quantity | None = None,
    ):
        self._fill(
            radiance=radiance,
            wavelength=wavelength,
            stars=stars,
            catalogue=catalogue,
            exponent=exponent,
            reference=reference,
        )


class FileBackground(Background):
    """From a file of wavelength and flux.

    Parameters
    ----------
    radiance : spectral radiance above zero
        At `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Wavelength of the radiance.
    stars : table, default none
        A field of stars.
    catalogue : table, default none
        Stars of a CSV at their sky positions.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "background"
    _kind = "file"

    def __init__(
        self,
        *,
        radiance: Quantity | None = None,
        wavelength: Quantity | None = None,
        stars: StarField | None = None,
        catalogue: StarCatalogue | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(
            radiance=radiance,
            wavelength=wavelength,
            stars=stars,
            catalogue=catalogue,
            file=file,
            unit=unit,
            column=column,
        )


class Detail(Table):
    """Displacement of dust and gas below their voxels where pixels resolve it, so that edges and fronts are rough at all
    lengths and voxels stay invisible close to the cloud. It moves what the camera sees, without a change of its mean;
    ionised gas, star depths and multiple scattering ignore it ([docs/method.md](method.md)).

    Parameters
    ----------
    seed : integer, default 1
        Seed of the noise.
    octaves : integer between 1 and 8, default 6
        Octaves of waves from four voxels downwards; unresolved octaves cost nothing.
    strength : number between 0 and 0.2, default 0.05
        Displacement relative to the wavelength, root mean square of a component; 0 disables detail.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "detail"

    def __init__(self, *, seed: int | None = None, octaves: int | None = None, strength: float | None = None):
        self._fill(seed=seed, octaves=octaves, strength=strength)


class Spectrograph(Table):
    """Hundreds of adjacent narrow passbands that share one march; FITS files store them as a cube with a spectral axis
    ([docs/observing.md](observing.md)).

    Parameters
    ----------
    low : wavelength above zero
        Lower edge of the first channel.
    high : wavelength above zero
        Upper edge of the last channel.
    count : integer between 1 and 4096
        Number of channels of equal width in wavelength.
    resolving_power : number between 1 and 1e7, default none
        Resolving power: wavelength over the full width at half maximum of a Gaussian line; by default channels have
        sharp edges.
    rest_wavelength : wavelength above zero, default the only line in range
        Vacuum wavelength of the line for velocities (RESTWAV).

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "spectrograph"

    def __init__(
        self,
        low: Quantity,
        high: Quantity,
        count: int,
        *,
        resolving_power: float | None = None,
        rest_wavelength: Quantity | None = None,
    ):
        self._fill(low=low, high=high, count=count, resolving_power=resolving_power, rest_wavelength=rest_wavelength)


class Band(Table):
    """Custom passbands, in addition to the sets and embedded passbands of `bands`.

    Kinds
    -----
    catalogue
        An embedded passband.
    file
        From a file of wavelength and throughput.
    points
        Piecewise linear; zero outside.
    top_hat
        1 within centre +- width/2.
    gaussian
        A Gaussian, truncated at 2.5 FWHM.
    cos2
        cos2(pi (lambda - centre)/(2 half_width)).
    polynomial
        Sum of c_i lambda^i with lambda in um, clipped at zero.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    passband : text
        Name in the catalogue `passbands`, such as "hst-wfc3-f656n". Of kind catalogue, required there.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and throughput. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.
    nm : list of numbers
        Wavelengths of the points, ascending [nm]. Of kind points, required there.
    throughput : list of numbers, each between 0 and 1
        Throughput at the points. Of kind points, required there.
    centre : wavelength
        Its middle. Of kind top_hat, gaussian, cos2, required there.
    width : wavelength above zero
        Its full width. Of kind top_hat, required there.
    fwhm : wavelength above zero
        Full width at half maximum. Of kind gaussian, required there.
    half_width : wavelength above zero
        Distance of its zeros from the centre. Of kind cos2, required there.
    coefficients : list of numbers
        c_0, c_1, ... Of kind polynomial, required there.
    low : wavelength
        Lower end. Of kind polynomial, required there.
    high : wavelength
        Upper end. Of kind polynomial, required there.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"

    def __init__(
        self,
        kind: Literal["catalogue", "file", "points", "top_hat", "gaussian", "cos2", "polynomial"],
        name: str,
        *,
        counting: Literal["energy", "photon"] | None = None,
        passband: str | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
        nm: Sequence[float] | None = None,
        throughput: Sequence[float] | None = None,
        centre: Quantity | None = None,
        width: Quantity | None = None,
        fwhm: Quantity | None = None,
        half_width: Quantity | None = None,
        coefficients: Sequence[float] | None = None,
        low: Quantity | None = None,
        high: Quantity | None = None,
    ):
        self._fill(
            kind=kind,
            name=name,
            counting=counting,
            passband=passband,
            file=file,
            unit=unit,
            column=column,
            nm=nm,
            throughput=throughput,
            centre=centre,
            width=width,
            fwhm=fwhm,
            half_width=half_width,
            coefficients=coefficients,
            low=low,
            high=high,
        )


class CatalogueBand(Band):
    """An embedded passband.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    passband : text
        Name in the catalogue `passbands`, such as "hst-wfc3-f656n".

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "catalogue"

    def __init__(self, name: str, passband: str, *, counting: Literal["energy", "photon"] | None = None):
        self._fill(name=name, counting=counting, passband=passband)


class FileBand(Band):
    """From a file of wavelength and throughput.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and throughput.
    unit : text, default the file's own
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1".
    column : text, default the only one, or the one named like its quantity
        Name or number of the file's column to read.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "file"

    def __init__(
        self,
        name: str,
        file: Path,
        *,
        counting: Literal["energy", "photon"] | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        self._fill(name=name, counting=counting, file=file, unit=unit, column=column)


class PointsBand(Band):
    """Piecewise linear; zero outside.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    nm : list of numbers
        Wavelengths of the points, ascending [nm].
    throughput : list of numbers, each between 0 and 1
        Throughput at the points.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "points"

    def __init__(
        self,
        name: str,
        nm: Sequence[float],
        throughput: Sequence[float],
        *,
        counting: Literal["energy", "photon"] | None = None,
    ):
        self._fill(name=name, counting=counting, nm=nm, throughput=throughput)


class TopHatBand(Band):
    """1 within centre +- width/2.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    centre : wavelength
        Its middle.
    width : wavelength above zero
        Its full width.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "top_hat"

    def __init__(
        self,
        name: str,
        centre: Quantity,
        width: Quantity,
        *,
        counting: Literal["energy", "photon"] | None = None,
    ):
        self._fill(name=name, counting=counting, centre=centre, width=width)


class GaussianBand(Band):
    """A Gaussian, truncated at 2.5 FWHM.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    centre : wavelength
        Its middle.
    fwhm : wavelength above zero
        Full width at half maximum.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "gaussian"

    def __init__(
        self,
        name: str,
        centre: Quantity,
        fwhm: Quantity,
        *,
        counting: Literal["energy", "photon"] | None = None,
    ):
        self._fill(name=name, counting=counting, centre=centre, fwhm=fwhm)


class Cos2Band(Band):
    """cos2(pi (lambda - centre)/(2 half_width)).

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    centre : wavelength
        Its middle.
    half_width : wavelength above zero
        Distance of its zeros from the centre.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "cos2"

    def __init__(
        self,
        name: str,
        centre: Quantity,
        half_width: Quantity,
        *,
        counting: Literal["energy", "photon"] | None = None,
    ):
        self._fill(name=name, counting=counting, centre=centre, half_width=half_width)


class PolynomialBand(Band):
    """Sum of c_i lambda^i with lambda in um, clipped at zero.

    Parameters
    ----------
    name : text
        Name in the output.
    counting : energy or photon, default energy
        Detector type: energy (R = T) or photon (R = T lambda/lambda_pivot); embedded passbands define it.
    coefficients : list of numbers
        c_0, c_1, ...
    low : wavelength
        Lower end.
    high : wavelength
        Upper end.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "band"
    _kind = "polynomial"

    def __init__(
        self,
        name: str,
        coefficients: Sequence[float],
        low: Quantity,
        high: Quantity,
        *,
        counting: Literal["energy", "photon"] | None = None,
    ):
        self._fill(name=name, counting=counting, coefficients=coefficients, low=low, high=high)


class Glare(Table):
    """Glare of bright points by a telescope or an eye: spikes, rings, a halo, seeing. It is applied to linear display
    colours; radiances do not depend on it.

    Parameters
    ----------
    optics : text, default hubble
        Optics of the glare.
    size : number between 0.01 and 20, default 0.5
        Size of spikes and rings: λ/D at 550 nm in thousandths of the longer edge.
    rotation : angle, default 0 deg
        Rotation of the optics, counterclockwise.
    seeing : number between 0 and 50, default 0
        Seeing, full width at half maximum in thousandths of the longer edge.
    halo : number between 0 and 1, default 0.02
        Fraction of light in the halo.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "display.glare"

    def __init__(
        self,
        *,
        optics: str | None = None,
        size: float | None = None,
        rotation: Quantity | None = None,
        seeing: float | None = None,
        halo: float | None = None,
    ):
        self._fill(optics=optics, size=size, rotation=rotation, seeing=seeing, halo=halo)


class Display(Table):
    """Palette and stretch of display pictures; radiances do not depend on them.

    Parameters
    ----------
    palette : text, default natural, or rgb outside the visible
        Assignment of bands to colours.
    matrix : list of numbers, default none
        Custom palette: red, green, blue of the first band, then of the next.
    balance : boolean, default false
        Scale each band to its own white, as usual for narrow bands.
    stretch : text, default asinh
        Curve from radiance to brightness.
    strength : number at least zero, default the stretch's own
        Its parameter.
    black : number at least zero, default 0
        Radiance of black [W m-2 sr-1, or of the balanced band].
    white : number at least zero, default level exceeded by the brightest 0.2 %
        Radiance of white.
    bits : integer between 8 and 16, default 8
        Bits per colour of a .png, 8 or 16; a .tif has 16, a .jpg 8.
    glare : table, default none
        Glare of bright points, [display.glare].

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "display"

    def __init__(
        self,
        *,
        palette: str | None = None,
        matrix: Sequence[float] | None = None,
        balance: bool | None = None,
        stretch: str | None = None,
        strength: float | None = None,
        black: float | None = None,
        white: float | None = None,
        bits: int | None = None,
        glare: Glare | None = None,
    ):
        self._fill(
            palette=palette,
            matrix=matrix,
            balance=balance,
            stretch=stretch,
            strength=strength,
            black=black,
            white=white,
            bits=bits,
            glare=glare,
        )


class Observation(Table):
    """Sky position of the image and unit of FITS files. Images then have world coordinates (equatorial or Galactic;
    projection TAN, ARC for domes, CAR for 360° images). Radiances do not depend on it; other files have radiances.

    Parameters
    ----------
    target : text
        Sky position of the centre of the whole image (of a dome: its axis, the zenith unless tilted): "18h18m48s
        -13d49m", "18:18:48 -13:49:00" or "274.7 -13.82" in degrees.
    frame : icrs or galactic, default icrs
        Frame of the target.
    position_angle : angle, default 0 deg
        Position angle of the image's up direction, from north through east; at 0 deg north is up and east left.
    distance : length above zero, default none
        Distance of the centre of an orthographic image, which converts lengths to angles; required there, unused by
        other cameras.
    unit : W m-2 sr-1, erg s-1 cm-2 arcsec-2, MJy/sr, R, photon s-1 m-2 sr-1, electron s-1, mag/arcsec2 AB, mag/arcsec2 ST or mag/arcsec2 Vega, default W m-2 sr-1
        Unit of FITS files; R is Rayleigh.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "observation"

    def __init__(
        self,
        target: str,
        *,
        frame: Literal["icrs", "galactic"] | None = None,
        position_angle: Quantity | None = None,
        distance: Quantity | None = None,
        unit: Literal["W m-2 sr-1", "erg s-1 cm-2 arcsec-2", "MJy/sr", "R", "photon s-1 m-2 sr-1", "electron s-1", "mag/arcsec2 AB", "mag/arcsec2 ST", "mag/arcsec2 Vega"] | None = None,
    ):
        self._fill(target=target, frame=frame, position_angle=position_angle, distance=distance, unit=unit)


class PointSpread(Table):
    """Point-spread functions, applied in sequence. Default: those of the preset, otherwise diffraction.

    Kinds
    -----
    airy
        Diffraction at the aperture, its obstruction and vanes.
    moffat
        Seeing: a core with wings, narrower in red light (Moffat 1969).
    gaussian
        A Gaussian, for guiding jitter, charge diffusion, or a first estimate.
    kernel
        Image of a point source, such as those of WebbPSF or Tiny Tim: .fits, .npy or .exr, with the source at its
        centre.

    Parameters
    ----------
    optics : text
        Telescope with a known pupil, instead of obstruction and vanes. Of kind airy.
    vanes : integer between 0 and 12
        Number of vanes of the secondary mirror. Of kind airy.
    vane_width : number between 1e-4 and 0.2
        Width of a vane relative to the aperture. Of kind airy.
    rotation : angle
        Rotation of the optics, counterclockwise. Of kind airy.
    fwhm : angle above zero
        Full width at half maximum at `wavelength`. Of kind moffat, gaussian, required there.
    beta : number between 1.01 and 100
        Exponent of the wings. Of kind moffat.
    wavelength : wavelength above zero
        Where `fwhm` holds. Of kind moffat, gaussian.
    exponent : number between -2 and 2
        Exponent of the width in wavelength. Of kind moffat, gaussian.
    file : path
        Image file; by default its first HDU or band. Of kind kernel, required there.
    hdu : text
        Name or number of the HDU of a FITS file, such as "OVERDIST". Of kind kernel.
    pixel_scale : angle above zero
        The angle of a pixel of the image. Of kind kernel, required there.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument.psf"

    def __init__(
        self,
        kind: Literal["airy", "moffat", "gaussian", "kernel"],
        *,
        optics: str | None = None,
        vanes: int | None = None,
        vane_width: float | None = None,
        rotation: Quantity | None = None,
        fwhm: Quantity | None = None,
        beta: float | None = None,
        wavelength: Quantity | None = None,
        exponent: float | None = None,
        file: Path | None = None,
        hdu: str | None = None,
        pixel_scale: Quantity | None = None,
    ):
        self._fill(
            kind=kind,
            optics=optics,
            vanes=vanes,
            vane_width=vane_width,
            rotation=rotation,
            fwhm=fwhm,
            beta=beta,
            wavelength=wavelength,
            exponent=exponent,
            file=file,
            hdu=hdu,
            pixel_scale=pixel_scale,
        )


class AiryPointSpread(PointSpread):
    """Diffraction at the aperture, its obstruction and vanes.

    Parameters
    ----------
    optics : text, default none
        Telescope with a known pupil, instead of obstruction and vanes.
    vanes : integer between 0 and 12, default 0
        Number of vanes of the secondary mirror.
    vane_width : number between 1e-4 and 0.2, default 0.01
        Width of a vane relative to the aperture.
    rotation : angle, default 0 deg
        Rotation of the optics, counterclockwise.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument.psf"
    _kind = "airy"

    def __init__(
        self,
        *,
        optics: str | None = None,
        vanes: int | None = None,
        vane_width: float | None = None,
        rotation: Quantity | None = None,
    ):
        self._fill(optics=optics, vanes=vanes, vane_width=vane_width, rotation=rotation)


class MoffatPointSpread(PointSpread):
    """Seeing: a core with wings, narrower in red light (Moffat 1969).

    Parameters
    ----------
    fwhm : angle above zero
        Full width at half maximum at `wavelength`.
    beta : number between 1.01 and 100, default 4.765
        Exponent of the wings.
    wavelength : wavelength above zero, default 500 nm
        Where `fwhm` holds.
    exponent : number between -2 and 2, default -0.2
        Exponent of the width in wavelength.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument.psf"
    _kind = "moffat"

    def __init__(
        self,
        fwhm: Quantity,
        *,
        beta: float | None = None,
        wavelength: Quantity | None = None,
        exponent: float | None = None,
    ):
        self._fill(fwhm=fwhm, beta=beta, wavelength=wavelength, exponent=exponent)


class GaussianPointSpread(PointSpread):
    """A Gaussian, for guiding jitter, charge diffusion, or a first estimate.

    Parameters
    ----------
    fwhm : angle above zero
        Full width at half maximum at `wavelength`.
    wavelength : wavelength above zero, default 550 nm
        Where `fwhm` holds.
    exponent : number between -2 and 2, default 0
        Exponent of the width in wavelength.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument.psf"
    _kind = "gaussian"

    def __init__(self, fwhm: Quantity, *, wavelength: Quantity | None = None, exponent: float | None = None):
        self._fill(fwhm=fwhm, wavelength=wavelength, exponent=exponent)


class KernelPointSpread(PointSpread):
    """Image of a point source, such as those of WebbPSF or Tiny Tim: .fits, .npy or .exr, with the source at its centre.

    Parameters
    ----------
    file : path
        Image file; by default its first HDU or band.
    hdu : text, default the first image
        Name or number of the HDU of a FITS file, such as "OVERDIST".
    pixel_scale : angle above zero
        The angle of a pixel of the image.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument.psf"
    _kind = "kernel"

    def __init__(self, file: Path, pixel_scale: Quantity, *, hdu: str | None = None):
        self._fill(file=file, hdu=hdu, pixel_scale=pixel_scale)


class Instrument(Table):
    """Telescope, atmosphere and detector with noise. `barnard observe` writes frames of counts and a master with errors
    and a mask ([docs/observing.md](observing.md)); `barnard render` ignores it.

    Parameters
    ----------
    preset : text, default none
        Predefined instrument; other keys override its values.
    aperture : length above zero, default of the preset
        Diameter of the aperture; required without a preset.
    obstruction : number between 0 and 0.99, default 0
        Diameter of the central obstruction relative to the aperture.
    collecting_area : area above zero, default of the aperture
        Collecting area, if not that of aperture and obstruction; Hubble's passbands include its obstruction.
    throughput : number between 1e-6 and 1, default 1
        Recorded fraction of the light, in addition to the passband.
    psf : list of tables, default airy
        Point-spread functions, applied in sequence, [[instrument.psf]].
    pixel_scale : angle above zero, default the picture's
        Angle per detector pixel; the camera's pixels must be at least as fine.
    sky : list of magnitudes, default dark
        Sky brightness per square arcsecond: one for all passbands, or one per passband.
    allow_foreign_filters : boolean, default false
        Allow catalogue passbands of other instruments; those of [[band]] always are.
    sky_system : ab, st or vega, default ab
        Magnitude system of `sky`.
    subtract_sky : boolean, default true
        Subtract the mean sky from the master; its noise remains.
    dark_current : dark current at least zero, default 0 e/s
        Dark current per pixel.
    read_noise : charge at least zero, default 0 e
        Read noise per pixel, standard deviation.
    gain : gain above zero, default 1 e/ADU
        Electrons of a count.
    bias : counts at least zero, default what reading needs
        Counts of an empty pixel; default: six times the read noise.
    full_well : charge above zero, default none
        Full well, electrons per pixel.
    bits : integer between 1 and 16, default 16
        Bits per count.
    pixel_size : length above zero, default 10 um
        Edge of a pixel, for cosmic rays.
    cosmic_rays : rate of hits at least zero, default 0 /cm2/s
        Rate of cosmic-ray hits.
    mosaic : text or list of texts, default none
        Passbands of 2 x 2 pixels of a colour sensor, row by row from the upper left; [] for none.
    exposure : time above zero, default 60 s
        Exposure of a frame.
    frames : integer between 1 and 10000, default 1
        Number of frames.
    seed : integer, default 1
        Seed of the noise.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "instrument"

    def __init__(
        self,
        *,
        preset: str | None = None,
        aperture: Quantity | None = None,
        obstruction: float | None = None,
        collecting_area: Quantity | None = None,
        throughput: float | None = None,
        psf: Sequence[PointSpread | dict[str, Any]] | None = None,
        pixel_scale: Quantity | None = None,
        sky: Sequence[Quantity] | Quantity | None = None,
        allow_foreign_filters: bool | None = None,
        sky_system: Literal["ab", "st", "vega"] | None = None,
        subtract_sky: bool | None = None,
        dark_current: Quantity | None = None,
        read_noise: Quantity | None = None,
        gain: Quantity | None = None,
        bias: Quantity | None = None,
        full_well: Quantity | None = None,
        bits: int | None = None,
        pixel_size: Quantity | None = None,
        cosmic_rays: Quantity | None = None,
        mosaic: str | Sequence[str] | None = None,
        exposure: Quantity | None = None,
        frames: int | None = None,
        seed: int | None = None,
    ):
        self._fill(
            preset=preset,
            aperture=aperture,
            obstruction=obstruction,
            collecting_area=collecting_area,
            throughput=throughput,
            psf=psf,
            pixel_scale=pixel_scale,
            sky=sky,
            allow_foreign_filters=allow_foreign_filters,
            sky_system=sky_system,
            subtract_sky=subtract_sky,
            dark_current=dark_current,
            read_noise=read_noise,
            gain=gain,
            bias=bias,
            full_well=full_well,
            bits=bits,
            pixel_size=pixel_size,
            cosmic_rays=cosmic_rays,
            mosaic=mosaic,
            exposure=exposure,
            frames=frames,
            seed=seed,
        )


class Output(Table):
    """Layers and encoding of output files. Layers separate the light by origin: `scattered`, `emission.NAME` of each
    gas, `background` and `stars`, whose sum is the picture; also `depth` and `tau` ([docs/shows.md](shows.md)).

    Parameters
    ----------
    layers : text or list of texts, default []
        Layers of an .exr or a .fits: light, depth, tau, all or none.
    channels : rgb or bands, default rgb
        Contents of light layers: rgb (linear colours at the picture's exposure) or bands (radiances).
    color_space : rec709 or acescg, default rec709
        Primaries of linear colours in an .exr.
    precision : half or float, default half
        Precision of colours in an .exr; radiances are always float.
    compression : none, rle, zips, zip, piz or pxr24, default zip
        Compression of an .exr; pxr24 keeps 24 bits per radiance.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "output"

    def __init__(
        self,
        *,
        layers: str | Sequence[str] | None = None,
        channels: Literal["rgb", "bands"] | None = None,
        color_space: Literal["rec709", "acescg"] | None = None,
        precision: Literal["half", "float"] | None = None,
        compression: Literal["none", "rle", "zips", "zip", "piz", "pxr24"] | None = None,
    ):
        self._fill(
            layers=layers,
            channels=channels,
            color_space=color_space,
            precision=precision,
            compression=compression,
        )


class PathTracer(Table):
    """Options of `--backend path`, the Monte Carlo path tracer.

    Parameters
    ----------
    samples : integer between 1 and 1e12, default 64
        Largest number of paths per pixel and band.
    target_error : number between 1e-6 and 1, default none
        Relative standard error of the worst band at which to stop earlier.
    seed : integer at least zero, default 1
        Seed of the noise.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "method.path"

    def __init__(self, *, samples: int | None = None, target_error: float | None = None, seed: int | None = None):
        self._fill(samples=samples, target_error=target_error, seed=seed)


class Reference(Table):
    """Options of `--backend reference`, the adaptive integrator.

    Parameters
    ----------
    accuracy : number between 1e-12 and 0.5, default 1e-5
        Allowed error of each pixel, relative to its radiance.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "method.reference"

    def __init__(self, *, accuracy: float | None = None):
        self._fill(accuracy=accuracy)


class Device(Table):
    """Options of `--backend gpu` and `auto`.

    Parameters
    ----------
    on_the_fly : boolean, default false
        Evaluate dust of a single field of kind "fbm" at every sample, instead of sampling it to a grid.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "method.gpu"

    def __init__(self, *, on_the_fly: bool | None = None):
        self._fill(on_the_fly=on_the_fly)


class Method(Table):
    """Method of spectral integrals.

    Parameters
    ----------
    name : text, default band_quadrature
        Name in the catalogue `methods`.
    accuracy : number between 1e-9 and 0.5, default 0.001
        Allowed error: spectral relative to the light without extinction, spatial relative to the image's rms.
    count : integer between 1 and 4096, default chosen by accuracy
        Fixed number of nodes, intervals, elements or samples per band, for comparisons.
    domain : list of wavelengths, each above zero, default that of each band (projection: that of all bands)
        Wavelength range of midpoint, gauss_legendre, preintegrated, analytic and projection.
    degree : integer between 0 and 12, default 5
        Degree of the spectral polynomials of analytic.
    range : number between 1e-6 and 1e6, default largest depth of the scene
        Largest optical depth of the basis of projection.
    criterion : mean, largest or filter, default mean
        Norm that the exponents of projection minimise over the range: mean error, largest error, or mean weighted by
        each filter.
    steps : integer between 1 and 1e6, default chosen by accuracy
        Fixed number of samples per ray, for comparisons.
    steps_per_voxel : number between 0.5 and 100, default chosen by accuracy
        Fixed number of samples per voxel edge.
    star_depth_voxels : integer between 1 and 12, default chosen by accuracy
        Fixed number of star-depth voxels per dust voxel edge, within the memory limit.
    bake : integer between 4 and 2048, default from the sampling error, 32 to 256
        Voxels along the longest edge of sampled functions.
    volumes : single or half, default single
        Precision of march volumes; half has errors of up to 1/700 and takes half of the memory.
    sparse : auto, always or never, default auto
        Omit volume pages of 16 x 16 x 16 voxels without dust and gas; auto does so from 64 MiB on if it saves a
        quarter.
    bounces : integer between 1 and 1000, default 1
        Largest number of scatterings of starlight, 1000 for all; light of gas and background scatters one time less.
    exact_stars : integer between 0 and 1e6, default all of up to 8; of more, one that emits over half of the light
        Number of the brightest stars to march individually; the light of the others is aggregated in cells beyond the
        neighbourhood of each (methods of nodes only).
    path : table, default defaults
        Options of the path tracer, [method.path].
    reference : table, default defaults
        Options of the reference, [method.reference].
    gpu : table, default defaults
        Options of graphics processors, [method.gpu].

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "method"

    def __init__(
        self,
        *,
        name: str | None = None,
        accuracy: float | None = None,
        count: int | None = None,
        domain: Sequence[Quantity] | Quantity | None = None,
        degree: int | None = None,
        range: float | None = None,
        criterion: Literal["mean", "largest", "filter"] | None = None,
        steps: int | None = None,
        steps_per_voxel: float | None = None,
        star_depth_voxels: int | None = None,
        bake: int | None = None,
        volumes: Literal["single", "half"] | None = None,
        sparse: Literal["auto", "always", "never"] | None = None,
        bounces: int | None = None,
        exact_stars: int | None = None,
        path: PathTracer | None = None,
        reference: Reference | None = None,
        gpu: Device | None = None,
    ):
        self._fill(
            name=name,
            accuracy=accuracy,
            count=count,
            domain=domain,
            degree=degree,
            range=range,
            criterion=criterion,
            steps=steps,
            steps_per_voxel=steps_per_voxel,
            star_depth_voxels=star_depth_voxels,
            bake=bake,
            volumes=volumes,
            sparse=sparse,
            bounces=bounces,
            exact_stars=exact_stars,
            path=path,
            reference=reference,
            gpu=gpu,
        )


class Animation(Table):
    """An animated key of the scene, such as a star's temperature, the dust's scale or the white level. Numbers are
    interpolated, with units and in lists; other values change in steps.

    Parameters
    ----------
    of : text
        Animated key, such as "star[0].temperature" (of the first star) or "display.white".
    times : list of times
        Ascending times of `values`.
    values : list of values
        Values at these times, written like the key itself, all in one unit.
    interpolation : catmull_rom, bezier, linear or step, default bezier
        Interpolation between values.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "animation"

    def __init__(
        self,
        of: str,
        times: Sequence[Quantity] | Quantity,
        values: Sequence[Any] | Quantity,
        *,
        interpolation: Literal["catmull_rom", "bezier", "linear", "step"] | None = None,
    ):
        self._fill(of=of, times=times, values=values, interpolation=interpolation)


class Frames(Table):
    """Frames of an animated scene; `barnard render --frames` renders them.

    Parameters
    ----------
    frames_per_second : number above zero and at most 1e6, default 30
        Frames per second.
    first_frame : integer between -1e9 and 1e9, default 1
        Number of the frame at 0 s.
    duration : time, default until the last key
        Time from the first frame to the last.
    shutter : angle between 0 and 360 deg, default 0 deg
        Shutter angle for motion blur; 360 deg is the whole frame time.
    shutter_moments : integer between 2 and 256, default 8
        Number of moments averaged per frame with motion blur.

    Raises
    ------
    SceneError
        If a key or a unit is invalid; ranges are checked when a scene is read.
    """

    _path = "sequence"

    def __init__(
        self,
        *,
        frames_per_second: float | None = None,
        first_frame: int | None = None,
        duration: Quantity | None = None,
        shutter: Quantity | None = None,
        shutter_moments: int | None = None,
    ):
        self._fill(
            frames_per_second=frames_per_second,
            first_frame=first_frame,
            duration=duration,
            shutter=shutter,
            shutter_moments=shutter_moments,
        )


__all__ = ["Grid", "Fbm", "Sphere", "Box", "Plummer", "Shell", "Slab", "Turbulence", "Expression", "Stereo", "Keyframe", "CameraPath", "Camera", "PerspectiveCamera", "perspective", "OrthographicCamera", "orthographic", "FisheyeCamera", "fisheye", "EquirectangularCamera", "equirectangular", "CubemapCamera", "cubemap", "Albedo", "ConstantAlbedo", "LinearAlbedo", "FileAlbedo", "Phase", "IsotropicPhase", "HenyeyGreensteinPhase", "DrainePhase", "RayleighPhase", "TabulatedPhase", "Dust", "Star", "BlackbodyStar", "StellarStar", "AtmosphereStar", "PowerLawStar", "FileStar", "StarTable", "Emission", "LinesEmission", "IonEmission", "RecombinationEmission", "LineListEmission", "FileEmission", "Gas", "StarField", "StarCatalogue", "Background", "BlackbodyBackground", "StellarBackground", "AtmosphereBackground", "PowerLawBackground", "FileBackground", "Detail", "Spectrograph", "Band", "CatalogueBand", "FileBand", "PointsBand", "TopHatBand", "GaussianBand", "Cos2Band", "PolynomialBand", "Glare", "Display", "Observation", "PointSpread", "AiryPointSpread", "MoffatPointSpread", "GaussianPointSpread", "KernelPointSpread", "Instrument", "Output", "PathTracer", "Reference", "Device", "Method", "Animation", "Frames"]
