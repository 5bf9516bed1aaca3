"""The tables of a scene: their keywords are the keys of scene files.

This file is made of the rows that the parser of scene files reads: `python python/write_tables.py` writes it.
A quantity is a value of astropy or unyt, or a text with its unit such as "39000 K"; what is None is not said.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, Union

from numpy.typing import ArrayLike

from ._field import Field, Sampled
from ._table import Table, checked

#: A value with its unit: of astropy, of unyt, or a text such as "0.4 pc".
Quantity = Union[str, Any]
#: Three lengths: [0.5, 0, -2] * u.pc, or "0.5 0 -2 pc".
Position = Union[str, Sequence[Quantity], Any]
Path = Union[str, os.PathLike]


class Grid(Sampled):
    """A three-dimensional array from .npy, .npz, FITS, HDF5 or OpenVDB, trilinear between voxel centres.

    Parameters
    ----------
    file : path
        The file, relative to the scene.
    array : text, default the only one
        Name of the array in an .npz or of the grid in a .vdb, path of the dataset in an HDF5 file, number or EXTNAME
        of the HDU in a FITS file.
    axes : text, default xyz (npy, npz), zyx (FITS), the file's own (HDF5, vdb)
        What the array's axes are, slowest first.
    low : position, default the file's own, or from voxel
        Lowest corner of the box that the voxels fill; where the file's own frame or voxel says the box, of the part
        of it that is read, to whole voxels.
    high : position, default the file's own, or from voxel
        Highest corner.
    voxel : length, default from low and high
        Edge of a cubic voxel, which says the box of all of the array.
    scale : length, default none
        What a length of one is in a file whose lengths have no unit, such as .vdb.
    centre : position, default 0 0 0 pc with voxel, the file's own otherwise
        Middle of the box of all of the array.
    every : whole number, default 1
        So many voxels along each axis become one, their mean; the file is read without all of it ever being in
        memory.
    memory : memory size, default none
        The array is made as coarse as it must be to take no more than this in memory: the least every that does.
    preset : text, default none
        A measured map of the Galaxy's dust, read as extinction at V in mag/pc (dust of scale = "1 mag/pc"):
        edenhofer24, leike20, lallement22, vergely22; it says array, unit and box, and clips.
    unit : text, default the file's own
        What the values are in (BUNIT of FITS, units of HDF5): number densities are turned into cm-3, extinctions per
        length into mag/pc, which dust and gas are scaled by; mass densities need mass_per_h; anything else is taken
        as it is.
    mass_per_h : number, default required for mass densities
        Mass of the gas per hydrogen nucleus in hydrogen atoms, by which mass densities become nuclei per cm3: 1.4 for
        solar abundances.
    wcs : boolean, default true
        Whether a file's own frame is read (CDELT or CD, CRPIX, CRVAL, CUNIT of FITS, coordinates or edges of HDF5,
        the transform of .vdb); false where low and high, or voxel, say better.
    storage : text, default as it is read; single for .vdb and where the array is more than half of the memory limit
        Single, half or byte: how values are kept, in blocks of 16 x 16 x 16 voxels of which those that are empty take
        no memory; half is right to 1 in 2048, byte to 1 in 508 of the largest in its block.
    factor : number, default 1
        Every value is multiplied by it.
    clip : boolean, default false, true with preset
        Blank, NaN and negative cells become zero instead of an error.
    copy : boolean, default true
        Whether an array is copied. A shared one becomes read-only, and older views of it must not be written to.

    `file` may be an array in memory: three axes, x, y and z unless `axes` says otherwise, of any float or integer type,
    order and stride; with a unit of astropy or unyt it is a number density.
    Of a labelled array of xarray, dimensions, even coordinates with a unit, and the unit of values are followed.
    A Dask array lies in bricks, its chunks: `render_bricks` renders it without gathering them.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "grid"

    def __init__(
        self,
        file: Path | ArrayLike,
        *,
        array: str | None = None,
        axes: str | None = None,
        low: Position | None = None,
        high: Position | None = None,
        voxel: Quantity | None = None,
        scale: Quantity | None = None,
        centre: Position | None = None,
        every: Quantity | None = None,
        memory: Quantity | None = None,
        preset: str | None = None,
        unit: str | None = None,
        mass_per_h: float | None = None,
        wcs: bool | None = None,
        storage: str | None = None,
        factor: float | None = None,
        clip: bool | None = None,
        copy: bool = True,
    ):
        super().__init__(
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
    """A cloud of fractional Brownian motion on simplex noise (values about 0 to 1).

    Parameters
    ----------
    seed : integer, default 1
        Number of the noise.
    centre : position, default 0 0 0 pc
        Middle of the cloud.
    radius : length, default 1 pc
        Where the cloud has ended; it fades from half of it on.
    scale : length, default 0.7 pc
        Size of the largest structures.
    octaves : integer, default 5
        Number of octaves, 1 to 12.
    lacunarity : number, default 2.0
        Frequency ratio of successive octaves, above 1.
    gain : number, default 0.5
        Amplitude ratio of successive octaves.
    offset : number, default 0.2
        Added before the cut at zero: more fills more of space.
    variant : text, default plain
        Plain or ridged.
    warp : length, default 0 pc
        How far a second noise bends space.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        variant: str | None = None,
        warp: Quantity | None = None,
    ):
        super().__init__(
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
        Its middle.
    radius : length
        Its radius.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "sphere"

    def __init__(self, radius: Quantity, *, centre: Position | None = None):
        super().__init__(centre=centre, radius=radius)


class Box(Field):
    """1 inside of an axis-aligned box.

    Parameters
    ----------
    low : position
        Its lowest corner.
    high : position
        Its highest corner.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "box"

    def __init__(self, low: Position, high: Position):
        super().__init__(low=low, high=high)


class Plummer(Field):
    """(1 + r2/a2)^(-5/2), cut at a radius.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Its middle.
    core : length
        The Plummer radius a.
    cut : length, default 5 core
        Beyond this radius it is zero.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "plummer"

    def __init__(self, core: Quantity, *, centre: Position | None = None, cut: Quantity | None = None):
        super().__init__(centre=centre, core=core, cut=cut)


class Shell(Field):
    """A spherical shell with a Gaussian wall.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        Its middle.
    radius : length
        Radius of the wall, whose density is 1 however large it is: a growing shell keeps its mass where `scale` falls
        with radius² thickness.
    thickness : length
        Standard deviation of the wall.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "shell"

    def __init__(self, radius: Quantity, thickness: Quantity, *, centre: Position | None = None):
        super().__init__(centre=centre, radius=radius, thickness=thickness)


class Slab(Field):
    """1 between two planes of any orientation, within a cube.

    Parameters
    ----------
    centre : position, default 0 0 0 pc
        A point on its middle plane, and middle of the cube.
    normal : direction, default [0, 0, 1]
        Its normal.
    thickness : length
        Distance of the planes.
    extent : length
        Half side of the cube that ends it.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(centre=centre, normal=normal, thickness=thickness, extent=extent)


class Turbulence(Field):
    """Lognormal density of supersonic turbulence in a box, of mean one, on voxels.

    Parameters
    ----------
    seed : integer, default 1
        Number of the random waves.
    low : position, default -1 -1 -1 pc
        The box's lower corner; the field is periodic in it.
    high : position, default 1 1 1 pc
        Its upper corner.
    voxels : integer, default 128
        Voxels along the longest edge: more of them show finer waves and change no others.
    outer_scale : length, default half of the shortest edge
        The scale at which turbulence is driven: larger waves are no stronger.
    mach : number, default 5
        Rms Mach number M; 0 is even.
    forcing : text, default mixed
        Solenoidal, mixed or compressive: b = 1/3, 0.4 or 1 in σ² = ln(1 + b² M²).
    plasma_beta : number, default no magnetic field
        Thermal over magnetic pressure.
    slope : number, default 3.667
        N of the spectrum k^-n of ln ρ in three dimensions: 3.6 to 4.3 in simulations (Federrath et al. 2010).

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        forcing: str | None = None,
        plasma_beta: float | None = None,
        slope: float | None = None,
    ):
        super().__init__(
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
    """An expression of other fields, for what several densities have in common.

    Parameters
    ----------
    formula : expression
        Of other fields, such as "cloud * (1 - hole)"; they may stand in any order, and be expressions themselves.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "field.*"
    _kind = "expression"

    def __init__(self, formula: str):
        super().__init__(formula=formula)


class Stereo(Table):
    """Two eyes: off-axis pairs in flat images, omni-directional stereo in images of all around. What a back end renders
    is both images in one.

    Parameters
    ----------
    eye_distance : length
        From eye to eye; a thirtieth of the distance to what is seen is deep, a hundredth shallow.
    convergence : length, default to the target
        Where both eyes see one image, which lies in the screen; what is nearer stands before it.
    arrangement : text, default over_under
        Over_under, the left eye on top, or side_by_side; `%V` in the name of an output makes a file of each eye.
    pole_merge : list of texts, default ["60 deg", "75 deg"]
        In images of all around, heights above and below the horizon between which both eyes become one.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "camera.stereo"

    def __init__(
        self,
        eye_distance: Quantity,
        *,
        convergence: Quantity | None = None,
        arrangement: str | None = None,
        pole_merge: Sequence[str] | None = None,
    ):
        super().__init__(
            eye_distance=eye_distance,
            convergence=convergence,
            arrangement=arrangement,
            pole_merge=pole_merge,
        )


class Keyframe(Table):
    """A keyframe: what the camera is at a moment. A key says what it changes. A file has the same as columns, with a
    unit in brackets behind the name: `time [s]`, then `x [pc]`, `y [pc]` and `z [pc]`, `target_x` or `direction_x` or
    `orientation_x` to `orientation_w`, `up_x` and so on, and `field_of_view [deg]`.

    Parameters
    ----------
    time : time
        When the camera is there.
    position : position, default goes on between its neighbours
        Where the observer is.
    target : position, default goes on between its neighbours
        What they look at.
    direction : direction, default towards the target
        Which way they look, in place of a target.
    orientation : list of numbers, default towards the target
        In place of target and up, the quaternion [x, y, z, w] that turns a camera which looks along -z, with y
        upwards.
    up : direction, default goes on between its neighbours
        What is up in the image.
    field_of_view : angle, default goes on between its neighbours
        Horizontal field of view, of a perspective camera.
    width : length, default goes on between its neighbours
        Width of the image, of an orthographic camera.
    aperture : angle, default goes on between its neighbours
        The angle across the circle, of a fisheye.
    tilt : angle, default goes on between its neighbours
        How far the middle of a fisheye leans from up towards the target.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
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
    """How the camera moves: through keyframes, or along a path that another program made. What a scene shows where no
    frame is asked for is its first moment.

    Parameters
    ----------
    key : list of tables, default none
        The keyframes, [[camera.path.key]]; two or more, or a file.
    file : path, default none
        A file of keyframes: a CSV, a camera path of Gaia Sky (.gsc), or the first animated camera of a glTF (.gltf,
        .glb).
    unit : length, default 1 pc
        How long a length of one is in a .gltf or .glb, and in columns of a CSV that say no unit.
    interpolation : text, default catmull_rom
        How the camera goes from key to key.
    ease : time, default 0 s
        How long the camera takes to get going at the beginning, and to come to rest at the end.
    constant_speed : boolean, default false
        The camera goes its way at one speed; times of the first and last key alone count.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "camera.path"

    def __init__(
        self,
        *,
        key: Sequence[Keyframe | dict[str, Any]] | None = None,
        file: Path | None = None,
        unit: Quantity | None = None,
        interpolation: str | None = None,
        ease: Quantity | None = None,
        constant_speed: bool | None = None,
    ):
        super().__init__(
            key=key,
            file=file,
            unit=unit,
            interpolation=interpolation,
            ease=ease,
            constant_speed=constant_speed,
        )


class Camera(Table):
    """Where the observer is; `kind` chooses the projection.

    Kinds
    -----
    perspective
        All rays from one point.
    orthographic
        Parallel rays, starting on the image plane.
    fisheye
        Equal angles from the middle outwards, black beside the circle: a dome master, with what the audience faces at
        the bottom.
    equirectangular
        All around, longitude by latitude, the target in the middle; twice as wide as high.
    cubemap
        All around, six faces of a cube one above the other, as environment maps of OpenEXR have them; six times as
        high as wide.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    field_of_view : angle
        Horizontal field of view, below 180 deg. Of kind perspective, required there.
    width : length
        Width of the image. Of kind orthographic, required there.
    aperture : angle
        The angle across the circle, up to 360 deg. Of kind fisheye.
    tilt : angle
        How far the middle of the image leans from up towards the target, 0 to 180 deg; at 90 deg the target is in the
        middle. Of kind fisheye.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
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


def perspective(
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
) -> Camera:
    """A camera: all rays from one point.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    field_of_view : angle
        Horizontal field of view, below 180 deg.
    """
    return Camera(
        "perspective",
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


perspective = checked(perspective, "camera")


def orthographic(
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
) -> Camera:
    """A camera: parallel rays, starting on the image plane.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    width : length
        Width of the image.
    """
    return Camera(
        "orthographic",
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


orthographic = checked(orthographic, "camera")


def fisheye(
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
) -> Camera:
    """A camera: equal angles from the middle outwards, black beside the circle: a dome master, with what the audience faces at the bottom.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    aperture : angle, default 180 deg
        The angle across the circle, up to 360 deg.
    tilt : angle, default 0 deg
        How far the middle of the image leans from up towards the target, 0 to 180 deg; at 90 deg the target is in the
        middle.
    """
    return Camera(
        "fisheye",
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


fisheye = checked(fisheye, "camera")


def equirectangular(
    position: Position,
    *,
    target: Position | None = None,
    up: Sequence[float] | None = None,
    size: int | Sequence[int] | None = None,
    crop: Sequence[float] | None = None,
    supersampling: int | None = None,
    stereo: Stereo | None = None,
    path: CameraPath | None = None,
) -> Camera:
    """A camera: all around, longitude by latitude, the target in the middle; twice as wide as high.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    """
    return Camera(
        "equirectangular",
        position=position,
        target=target,
        up=up,
        size=size,
        crop=crop,
        supersampling=supersampling,
        stereo=stereo,
        path=path,
    )


equirectangular = checked(equirectangular, "camera")


def cubemap(
    position: Position,
    *,
    target: Position | None = None,
    up: Sequence[float] | None = None,
    size: int | Sequence[int] | None = None,
    crop: Sequence[float] | None = None,
    supersampling: int | None = None,
    stereo: Stereo | None = None,
    path: CameraPath | None = None,
) -> Camera:
    """A camera: all around, six faces of a cube one above the other, as environment maps of OpenEXR have them; six times as high as wide.

    Parameters
    ----------
    position : position
        Where the observer is.
    target : position, default 0 0 0 pc
        What they look at.
    up : direction, default [0, 1, 0]
        What is up in the image.
    size : [width, height], default [512, 512]
        Pixels of the image.
    crop : list of numbers, default the whole image
        [column, row, width, height] of the part that is rendered, in pixels from the upper left corner.
    supersampling : integer, default 1
        Rays along each side of a pixel, 1 to 16.
    stereo : table, default one eye
        Two eyes beside each other, [camera.stereo].
    path : table, default the camera stands still
        How the camera moves, [camera.path].
    """
    return Camera(
        "cubemap",
        position=position,
        target=target,
        up=up,
        size=size,
        crop=crop,
        supersampling=supersampling,
        stereo=stereo,
        path=path,
    )


cubemap = checked(cubemap, "camera")


class Albedo(Table):
    """The part of extinction that scatters.

    Kinds
    -----
    constant
        The same at every wavelength; albedo = 0.6 is short for it.
    linear
        Value + slope (lambda - at)/100 nm, cut to 0 to 1.
    file
        From a file of wavelength and albedo.

    Parameters
    ----------
    value : number
        Albedo at the wavelength `at`, 0 to 1. Of kind constant, linear, required there.
    slope : number
        Change per 100 nm. Of kind linear.
    at : wavelength
        Where the value holds. Of kind linear.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and albedo. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(kind=kind, value=value, slope=slope, at=at, file=file, unit=unit, column=column)


class Phase(Table):
    """How scattered light is spread over angle; cos θ = +1 is forward.

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
    g : number
        Shape parameter, -0.999 to 0.999. Of kind henyey_greenstein, draine.
    g_file : path
        Text, ECSV, VOTable or FITS table of wavelength and g. Of kind henyey_greenstein, draine.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind
        henyey_greenstein, draine.
    column : text
        Name or number of the file's column to read. Of kind henyey_greenstein, draine.
    alpha : number
        0 is Henyey-Greenstein, 1 with g = 0 is Rayleigh. Of kind draine.
    file : path
        The CSV. Of kind tabulated, required there.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(kind=kind, g=g, g_file=g_file, unit=unit, column=column, alpha=alpha, file=file)


class Dust(Table):
    """Dust that absorbs and scatters.

    Parameters
    ----------
    density : expression
        Of the fields, such as "cloud" or "n_H * (1 - x_ion)".
    scale : extinction
        Of density 1: per length ("2 mag/pc" of A_V, "4 /pc" of depth), or for a density in cm-3 per column of
        hydrogen ("5.32e-22 mag cm2") or of mass ("200 cm2/g", with mass_per_h).
    mass_per_h : number, default required for a scale per mass
        Mass per hydrogen nucleus in hydrogen atoms, of what the scale is per gram of: 1.4 for all of the gas.
    law : text, default draine03_rv31
        Extinction law.
    r_v : number, default 3.1
        A(V)/E(B-V), for laws that take it.
    albedo : number or table, default that of the law's grains
        Part of extinction that scatters; laws of the Milky Way that are extinction alone take Draine 2003 of the
        nearest R_V.
    phase : table, default isotropic
        Spread of scattered light over angle.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
            density=density,
            scale=scale,
            mass_per_h=mass_per_h,
            law=law,
            r_v=r_v,
            albedo=albedo,
            phase=phase,
        )


class Star(Table):
    """A star; `kind` chooses the shape of its spectrum, and exactly one scale says how bright it is.

    Kinds
    -----
    blackbody
        Planck function of a temperature.
    stellar
        The spectrum of a type of star (library of Pickles 1998, interpolated between its types).
    atmosphere
        A hot star by temperature and gravity (model atmospheres of Kurucz 1993, 10000 to 50000 K).
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
        Whether the star itself is drawn, as an unresolved source.
    luminosity : luminosity, default one scale is needed
        Bolometric luminosity.
    radius : length, default one scale is needed
        Radius, for black bodies and atmospheres, such as "9.9 Rsun".
    spectral_luminosity : spectral luminosity, default one scale is needed
        Luminosity per wavelength at `wavelength`.
    wavelength : wavelength, default 550 nm
        Where spectral_luminosity holds.
    magnitude : magnitude, default one scale is needed
        Apparent magnitude in `magnitude_band` at `distance`, behind the `extinction` on the way.
    extinction : magnitude, default 0
        A_V of the dust between the star and who measured its magnitude; it is taken off.
    extinction_law : text, default gordon23
        The law of that dust, with R_V = 3.1 where it has one.
    magnitude_band : text, default johnson-V
        An embedded passband.
    distance : length, default needed with magnitude
        Where the magnitude was seen from.
    magnitude_system : text, default vega; required for passbands whose magnitudes are not
        Vega or ab.
    temperature : temperature
        Effective temperature, 10000 to 50000 K. Of kind blackbody, atmosphere, required there.
    type : text
        Spectral type, such as "O9.5V" or "K0 III", of the catalogue `stars`. Of kind stellar, required there.
    log_g : number
        Surface gravity, the decadic logarithm of cm s-2; the hotter, the higher it must be. Of kind atmosphere.
    exponent : number
        Exponent in wavelength. Of kind power_law, required there.
    reference : wavelength
        Where it is one. Of kind power_law.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        magnitude_system: str | None = None,
        temperature: Quantity | None = None,
        type: str | None = None,
        log_g: float | None = None,
        exponent: float | None = None,
        reference: Quantity | None = None,
        file: Path | None = None,
        unit: str | None = None,
        column: str | None = None,
    ):
        super().__init__(
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


class StarTable(Table):
    """Stars of a CSV, one a row. Columns are named like the keys of [[star]], `position` being x, y and z; a unit may
    stand behind the name, as in `temperature [K]`, and, but for places, in the cell; otherwise lengths are in pc,
    radii in Rsun, temperatures in K, luminosities in Lsun, magnitudes in mag. An empty cell says nothing; other
    columns are left out. Any key of [[star]] beside `file` holds for all of its stars. `kind` is "stellar" where
    there is a column `type`, "blackbody" otherwise. Columns are parted by commas, semicolons, tabs or blanks; lines
    that begin with `#` are skipped.

    Parameters
    ----------
    file : path
        The CSV: a line of column names, then a star in each row.
    columns : list of texts, default all that are keys of [[star]]
        Which columns are read, beside x, y and z.
    visible : boolean, default true
        Whether the stars themselves are drawn.
    magnitude_band : text, default johnson-V
        An embedded passband, for a column of magnitudes.
    distance : length, default needed with magnitudes
        Where magnitudes were seen from.
    magnitude_system : text, default vega; required for passbands whose magnitudes are not
        Vega or ab.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "star_table"

    def __init__(
        self,
        file: Path,
        *,
        columns: Sequence[str] | None = None,
        visible: bool | None = None,
        magnitude_band: str | None = None,
        distance: Quantity | None = None,
        magnitude_system: str | None = None,
    ):
        super().__init__(
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
        All lines of an ion from its emissivities; density is n_e n_H in cm-6.
    recombination
        Continuum of recombining hydrogen (free-bound, free-free, two-photon); density is n_e n_H+ in cm-6.
    line_list
        A model nebula's lines relative to H-beta.
    file
        A tabulated spectrum.

    Parameters
    ----------
    name : text, default emission N
        Its name.
    density : expression
        Of the fields, such as "n_H^2 * x_ion^2".
    doppler_fwhm : velocity, default 0 km/s
        Full width at half maximum of its lines.
    velocity : list of texts, default at rest
        How fast it moves along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]: its lines are
        seen where what comes closer or recedes has them, from the scene's own camera.
    velocity_step : velocity, default 10 km/s
        Velocities that are told apart: half of a channel or less.
    scale : emission coefficient
        Of density 1 for spectral strength 1, such as "1e-25 W/m3/sr". Of kind lines, line_list, file, required there.
    lines : list of tables
        { wavelength = "656.46 nm", strength = 3 }, wavelength in vacuum, strength integrated over the line. Of kind
        lines, required there.
    continuum : number
        Strength per nm at `continuum_at`. Of kind lines.
    continuum_at : wavelength
        Where the continuum has that strength. Of kind lines.
    continuum_exponent : number
        Exponent of the continuum in wavelength. Of kind lines.
    ion : text
        Such as "H1", "O3", "N2", "S2", of the catalogue `ions`. Of kind ion, required there.
    temperature : temperature
        Of the electrons, 6000 to 15000 K. Of kind ion, recombination, required there.
    electron_density : number density
        100 to 1e4 cm-3. Of kind ion, recombination, required there.
    abundance : number
        N_ion / n_H. Of kind ion.
    list : text
        A name of the catalogue `line-lists`. Of kind line_list, required there.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and strength per nm. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "emission"

    def __init__(
        self,
        kind: Literal["lines", "ion", "recombination", "line_list", "file"],
        density: str,
        *,
        name: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: Sequence[str] | None = None,
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
        super().__init__(
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


class Gas(Table):
    """Gas that the scene's stars ionise: which part of it is, how warm it is, and which lines it shines in through the
    passbands follow from its density and the stars ([docs/gas.md](gas.md)).

    Parameters
    ----------
    density : expression
        Nuclei of hydrogen in cm-3, of the fields, such as "n_H".
    abundances : text or list, default orion
        Orion, solar, lmc or hii40, or He, C, N, O, Ne, Mg, Si and S for one nucleus of hydrogen; of six numbers Mg
        and Si are left out.
    voxels : whole number, default a grid's own; 96 for a function
        Voxels along the longest edge: more than a grid has show its fronts finer.
    dust_absorption : number, default 0
        Cross section that dust absorbs ionising light with, in cm2 for a nucleus of hydrogen, such as 1e-21.
    temperature : temperature, default where heating and cooling are in balance
        Of all electrons, 500 to 60000 K, in place of the one that follows.
    diffuse : text, default outward
        Where light of recombinations is absorbed: outward, along the stars' rays, or on_the_spot, where it is made.
    doppler_fwhm : velocity, default 0 km/s
        Full width at half maximum that turbulence gives its lines, with which the thermal one, 19 km/s of hydrogen at
        8000 K, adds in squares.
    velocity : list of texts, default at rest
        How fast it moves along x, y and z in km/s, three expressions such as ["20*x", "20*y", "20*z"]: its lines are
        seen where what comes closer or recedes has them, from the scene's own camera.
    velocity_step : velocity, default 10 km/s
        Velocities that are told apart: half of a channel or less.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "gas"

    def __init__(
        self,
        density: str,
        *,
        abundances: str | Sequence[str] | None = None,
        voxels: Quantity | None = None,
        dust_absorption: float | None = None,
        temperature: Quantity | None = None,
        diffuse: str | None = None,
        doppler_fwhm: Quantity | None = None,
        velocity: Sequence[str] | None = None,
        velocity_step: Quantity | None = None,
    ):
        super().__init__(
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
    """Stars at infinity, the same from every camera.

    Parameters
    ----------
    seed : integer, default 1
        Number of the field.
    density : density on the sky, default 2000 /deg2
        Stars per solid angle.
    brightest : number, default 8
        V magnitude (Vega) of the brightest.
    faintest : number, default 18
        V magnitude (Vega) of the faintest; counts grow as 10^(0.4 m).

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(seed=seed, density=density, brightest=brightest, faintest=faintest)


class StarCatalogue(Table):
    """Stars of a CSV at infinity, where they are on the sky. Columns: `ra` and `dec`, or `glon` and `glat` (numbers in
    degrees, or texts such as 18h18m48s),                `magnitude` or the name of a passband (`johnson-V`; Gaia's
    `phot_g_mean_mag`, `phot_bp_mean_mag` and `phot_rp_mean_mag` are known), a second magnitude, `temperature` or
    `type` for the colour, and `name`;                other columns are left out, and rows without a magnitude. A star
    whose colour is a second magnitude has both.

    Parameters
    ----------
    file : path
        The CSV: a line of column names, then a star in each row.
    axes : text, default observation
        Observation: the sky lies as [observation] says of every picture, from wherever it is taken; icrs or galactic:
        x, y and z of the scene are those of the sky.
    magnitude_band : text, default johnson-V
        An embedded passband, for a column `magnitude`.
    magnitude_system : text, default vega; required for passbands whose magnitudes are not
        Vega or ab.
    temperature : temperature, default 5800 K
        Of stars of which neither type nor temperature nor a second magnitude is known.
    epoch : number, default that of the catalogue
        The year to which stars are moved by their proper motions, columns pmra and pmdec in mas/yr, such as 2026.5.
    catalogue_epoch : number, default column ref_epoch; 2000 for HYG
        The year of the positions, where epoch is given.
    faintest : number, default none
        Stars of larger magnitudes are left out.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "background.catalogue"

    def __init__(
        self,
        file: Path,
        *,
        axes: str | None = None,
        magnitude_band: str | None = None,
        magnitude_system: str | None = None,
        temperature: Quantity | None = None,
        epoch: float | None = None,
        catalogue_epoch: float | None = None,
        faintest: float | None = None,
    ):
        super().__init__(
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
    """What lies behind the cloud: with a `kind` (the spectra of stars, above) an even light, with `[background.stars]` a
    field of stars.

    Kinds
    -----
    blackbody
        Planck function of a temperature.
    stellar
        The spectrum of a type of star (library of Pickles 1998, interpolated between its types).
    atmosphere
        A hot star by temperature and gravity (model atmospheres of Kurucz 1993, 10000 to 50000 K).
    power_law
        (lambda/reference)^exponent.
    file
        From a file of wavelength and flux.

    Parameters
    ----------
    radiance : spectral radiance
        At `wavelength`.
    wavelength : wavelength, default 550 nm
        Where the radiance holds.
    stars : table, default none
        A field of stars as well.
    catalogue : table, default none
        Stars of a CSV as well, where they are on the sky.
    temperature : temperature
        Effective temperature, 10000 to 50000 K. Of kind blackbody, atmosphere, required there.
    type : text
        Spectral type, such as "O9.5V" or "K0 III", of the catalogue `stars`. Of kind stellar, required there.
    log_g : number
        Surface gravity, the decadic logarithm of cm s-2; the hotter, the higher it must be. Of kind atmosphere.
    exponent : number
        Exponent in wavelength. Of kind power_law, required there.
    reference : wavelength
        Where it is one. Of kind power_law.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and flux density. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
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


class Detail(Table):
    """Noise that continues the spectrum of dust and gas below their voxels, where a pixel sees finer than those: a grid
    of 128 voxels does not show its edges from near by. It multiplies what eyes see of densities, and keeps their
    mean; depths of stars and light that scatters more than once are those without it ([docs/method.md](method.md)).

    Parameters
    ----------
    seed : integer, default 1
        Number of the noise.
    octaves : integer, default 4
        Octaves of waves from two voxels downwards, 1 to 8; pixels that do not see them cost nothing.
    strength : number, default 1
        Factor of the deviations; 0 is none.
    deviation : number, default as measured on each grid
        Deviation of ln density in the octave of two voxels: 0.1 is soft, 0.5 rough.
    slope : number, default as measured on each grid
        N of the spectrum k^-n that is continued; 3.667 is Kolmogorov's.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "detail"

    def __init__(
        self,
        *,
        seed: int | None = None,
        octaves: int | None = None,
        strength: float | None = None,
        deviation: float | None = None,
        slope: float | None = None,
    ):
        super().__init__(seed=seed, octaves=octaves, strength=strength, deviation=deviation, slope=slope)


class Spectrograph(Table):
    """Hundreds of narrow passbands side by side, which share one march; FITS files hold them as a cube with a spectral
    axis ([docs/observing.md](observing.md)).

    Parameters
    ----------
    low : wavelength
        Where the first channel begins.
    high : wavelength
        Where the last channel ends.
    count : integer
        The number of channels, of equal widths in wavelength, up to 4096.
    resolving_power : number, default none
        Wavelength over the full width at half maximum of a line, a Gaussian; without it a channel sees what lies
        within it alone.
    rest_wavelength : wavelength, default the only line in range
        Of the line, in vacuum, that readers of the cube tell velocities from (RESTWAV).

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
            low=low,
            high=high,
            count=count,
            resolving_power=resolving_power,
            rest_wavelength=rest_wavelength,
        )


class Band(Table):
    """Passbands of one's own, beside the sets and embedded passbands of `bands`.

    Kinds
    -----
    catalogue
        An embedded passband.
    file
        From a file of wavelength and throughput.
    points
        Straight lines between points; zero outside of them.
    top_hat
        One within centre +- width/2.
    gaussian
        A Gaussian, cut at 2.5 FWHM.
    cos2
        Cos2(pi (lambda - centre)/(2 half_width)).
    polynomial
        Sum of c_i lambda^i with lambda in um, cut at zero.

    Parameters
    ----------
    name : text
        Its name in the output.
    counting : text, default energy
        What the detector counts: energy (R = T), or photon (R = T lambda/lambda_pivot); embedded passbands know.
    passband : text
        Such as "hst-wfc3-f656n", of the catalogue `passbands`. Of kind catalogue, required there.
    file : path
        Text, ECSV, VOTable or FITS table of wavelength and throughput. Of kind file, required there.
    unit : text
        Unit of the file's spectral axis where the file states none, such as "angstrom", "um" or "cm-1". Of kind file.
    column : text
        Name or number of the file's column to read. Of kind file.
    nm : list of numbers
        Wavelengths of the points, ascending [nm]. Of kind points, required there.
    throughput : list of numbers
        Throughput at the points, 0 to 1. Of kind points, required there.
    centre : wavelength
        Its middle. Of kind top_hat, gaussian, cos2, required there.
    width : wavelength
        Its full width. Of kind top_hat, required there.
    fwhm : wavelength
        Its full width at half maximum. Of kind gaussian, required there.
    half_width : wavelength
        Where it reaches zero on both sides. Of kind cos2, required there.
    coefficients : list of numbers
        C_0, c_1, . Of kind polynomial, required there.
    low : wavelength
        Lower end. Of kind polynomial, required there.
    high : wavelength
        Upper end. Of kind polynomial, required there.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "band"

    def __init__(
        self,
        kind: Literal["catalogue", "file", "points", "top_hat", "gaussian", "cos2", "polynomial"],
        name: str,
        *,
        counting: str | None = None,
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
        super().__init__(
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


class Glare(Table):
    """What a telescope or an eye makes of bright points in a picture: spikes, rings, a halo, seeing. It is spread in
    linear light over all that the picture shows; radiances stay what they are.

    Parameters
    ----------
    optics : text, default hubble
        The telescope, or the eye.
    size : number, default 0.5
        Λ/D at 550 nm in thousandths of the picture's longer edge: how wide spikes and rings are.
    rotation : angle, default 0 deg
        How far the optics are turned, counterclockwise.
    seeing : number, default 0
        Full width at half maximum of what the air does, in thousandths of the longer edge.
    halo : number, default 0.02
        The part of the light that mirrors and lenses scatter around its point.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(optics=optics, size=size, rotation=rotation, seeing=seeing, halo=halo)


class Display(Table):
    """Palette and stretch of pictures; they never touch the radiance.

    Parameters
    ----------
    palette : text, default natural, or rgb outside the visible
        Which band is shown in which colour.
    matrix : list of numbers, default none
        A palette of one's own: red, green, blue of the first band, then of the next.
    balance : boolean, default false
        Each band is first scaled to its own white, as is usual for narrow bands.
    stretch : text, default asinh
        Curve from radiance to brightness.
    strength : number, default the stretch's own
        Its parameter.
    black : number, default 0
        Radiance that is black [W m-2 sr-1, or of the balanced band].
    white : number, default the brightest 0.2 % lie above
        Radiance that is white.
    bits : integer, default 8
        8 or 16: bits of each colour in a .png; a .tif has 16, a .jpg 8.
    glare : table, default none
        What optics make of bright points, [display.glare].

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
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
    """Where on the sky the picture is taken: images then have world coordinates (RA and Dec or Galactic; TAN, ARC of a
    dome, CAR of an image of all around), and FITS files the unit that is asked for. Nothing that is rendered depends
    on it; other files hold radiances.

    Parameters
    ----------
    target : text
        The place of the sky in the middle of the camera's whole image (of a dome its own axis, the zenith unless it
        is tilted): "18h18m48s -13d49m", "18:18:48 -13:49:00" or "274.7 -13.82" in degrees.
    frame : text, default icrs
        Icrs or galactic: what the target's two angles are.
    position_angle : angle, default 0 deg
        Of the picture's up, from north through east; with 0 deg north is up and east left.
    distance : length, default none
        How far away the middle of an orthographic image is, needed there: its lengths become angles; other cameras
        stand where they stand and do not ask.
    unit : text, default W m-2 sr-1
        What FITS files hold: W m-2 sr-1, erg s-1 cm-2 arcsec-2, MJy/sr, R (Rayleigh), photon s-1 m-2 sr-1,
        mag/arcsec2 AB, mag/arcsec2 ST or mag/arcsec2 Vega.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "observation"

    def __init__(
        self,
        target: str,
        *,
        frame: str | None = None,
        position_angle: Quantity | None = None,
        distance: Quantity | None = None,
        unit: str | None = None,
    ):
        super().__init__(target=target, frame=frame, position_angle=position_angle, distance=distance, unit=unit)


class PointSpread(Table):
    """What spreads the light of a point: several act one after the other. Where there is none, the preset's, or
    diffraction alone.

    Kinds
    -----
    airy
        Diffraction at the aperture, its obstruction and vanes (see optics.rs for the equation).
    moffat
        Seeing: a core with wings, narrower in red light (Moffat 1969).
    gaussian
        A Gaussian: jitter of the guiding, diffusion of charge, or a first guess.
    kernel
        An image of a point, such as those of WebbPSF or Tiny Tim: .fits, .npy or .exr; its middle is the point.

    Parameters
    ----------
    optics : text
        A telescope whose pupil is known, in place of obstruction and vanes. Of kind airy.
    vanes : integer
        Vanes that hold the secondary mirror, up to 12. Of kind airy.
    vane_width : number
        How wide a vane is, as a part of the aperture. Of kind airy.
    rotation : angle
        How far the optics are turned, counterclockwise. Of kind airy.
    fwhm : angle
        Full width at half maximum at `wavelength`. Of kind moffat, gaussian, required there.
    beta : number
        How steep the wings are, above 1. Of kind moffat.
    wavelength : wavelength
        Where `fwhm` holds. Of kind moffat, gaussian.
    exponent : number
        The width goes with this power of wavelength. Of kind moffat, gaussian.
    file : path
        The image; of several HDUs or bands the first. Of kind kernel, required there.
    hdu : text
        Name or number of the HDU of a FITS file, such as "OVERDIST". Of kind kernel.
    pixel_scale : angle
        The angle of a pixel of the image. Of kind kernel, required there.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
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


class Instrument(Table):
    """What records the picture: a telescope, the air, a detector and its noise. `barnard observe` makes frames of counts
    and a master of it, with errors and a mask ([docs/observing.md](observing.md)); `barnard render` shows what is
    there.

    Parameters
    ----------
    preset : text, default none
        An instrument that there is; keys beside it replace what it says.
    aperture : length, default of the preset
        Diameter of the aperture, needed without a preset.
    obstruction : number, default 0
        Diameter of what stands in the middle of the aperture, as a part of it.
    collecting_area : area, default of the aperture
        The area that collects light, where it is another: passbands of Hubble hold its obstruction.
    throughput : number, default 1
        The part of the light that is recorded, beside what the passband says.
    psf : list of tables, default airy
        What spreads the light of a point, one after the other, [[instrument.psf]].
    pixel_scale : angle, default the picture's
        The angle that a pixel of the detector sees; the camera's pixels must be as fine.
    sky : list of texts, default dark
        Brightness of the sky in mag/arcsec2, such as "21.6 mag": one for all passbands, or one for each.
    allow_foreign_filters : boolean, default false
        Whether a preset records through passbands of the catalogue that it does not have; those of [[band]] are its
        own.
    sky_system : text, default ab
        Ab, st or vega: the zero point of `sky`.
    subtract_sky : boolean, default true
        Whether the sky's mean is taken away from the master; its noise stays.
    dark_current : dark current, default 0 e/s
        Electrons that a pixel gathers in the dark.
    read_noise : charge, default 0 e
        Standard deviation of reading a pixel.
    gain : gain, default 1 e/ADU
        Electrons of a count.
    bias : counts, default what reading needs
        Counts of an empty pixel; six times what reading it scatters by where nothing is said.
    full_well : charge, default none
        Most electrons of a pixel.
    bits : integer, default 16
        Bits of a count, up to 16.
    pixel_size : length, default 10 um
        Edge of a pixel, for cosmic rays.
    cosmic_rays : rate of hits, default 0 /cm2/s
        Hits of cosmic rays.
    mosaic : list of texts, default none
        The passbands that two by two pixels see, from the upper left along rows: a colour sensor; [] for none.
    exposure : time, default 60 s
        Exposure of a frame.
    frames : integer, default 1
        Number of frames.
    seed : integer, default 1
        Number of the noise.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        sky: Sequence[str] | None = None,
        allow_foreign_filters: bool | None = None,
        sky_system: str | None = None,
        subtract_sky: bool | None = None,
        dark_current: Quantity | None = None,
        read_noise: Quantity | None = None,
        gain: Quantity | None = None,
        bias: Quantity | None = None,
        full_well: Quantity | None = None,
        bits: int | None = None,
        pixel_size: Quantity | None = None,
        cosmic_rays: Quantity | None = None,
        mosaic: Sequence[str] | None = None,
        exposure: Quantity | None = None,
        frames: int | None = None,
        seed: int | None = None,
    ):
        super().__init__(
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
    """What files hold beside the picture, and how. Layers say what its light comes from and where: `scattered`,
    `emission.NAME` of each gas, `background` and `stars`, whose sum is the picture, `depth` and `tau`
    ([docs/shows.md](shows.md)).

    Parameters
    ----------
    layers : list of texts, default []
        Light, depth, tau, all or none: layers of an .exr or a .fits.
    channels : text, default rgb
        Rgb or bands: what layers of light hold, linear colours in the picture's exposure or radiances.
    color_space : text, default rec709
        Rec709 or acescg: primaries of linear colours in an .exr.
    precision : text, default half
        Half or float: how an .exr holds colours; radiances are float always.
    compression : text, default zip
        None, rle, zips, zip, piz or pxr24: how an .exr is packed; pxr24 keeps 24 bits of each radiance.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "output"

    def __init__(
        self,
        *,
        layers: Sequence[str] | None = None,
        channels: str | None = None,
        color_space: str | None = None,
        precision: str | None = None,
        compression: str | None = None,
    ):
        super().__init__(
            layers=layers,
            channels=channels,
            color_space=color_space,
            precision=precision,
            compression=compression,
        )


class Method(Table):
    """How spectral integrals are done.

    Parameters
    ----------
    name : text, default band_quadrature
        A name of the catalogue `methods`.
    accuracy : number, default 0.001
        Allowed error: spectral relative to the light without extinction, spatial relative to the image's rms.
    count : integer, default chosen by accuracy
        Fixed number of nodes, intervals, elements or samples a band, for comparisons.
    domain : list of texts, default each band's own (projection: that of all bands)
        Wavelengths between which midpoint, gauss_legendre, preintegrated, analytic and projection work, such as ["300
        nm", "1 um"].
    degree : integer, default 5
        Degree of the polynomials that stand for spectra in analytic.
    range : number, default what the scene reaches
        Largest optical depth that the basis of projection is made for.
    criterion : text, default mean
        What the exponents of projection minimise over the range: the mean error, the largest, or the mean weighted by
        each filter.
    steps : integer, default chosen by accuracy
        Fixed number of samples a ray, for comparisons.
    steps_per_voxel : number, default chosen by accuracy
        0.5 to 100: fixed number of samples in each voxel edge, where `steps` does not say how many a ray has.
    star_depth_voxels : integer, default chosen by accuracy
        1 to 12: fixed number of voxels of star depths along one of dust, within the limit of memory.
    bake : integer, default by the sampling error, 32 to 256
        4 to 2048: voxels along the longest edge onto which functions are sampled for the fast back ends.
    volumes : text, default single
        Single or half: how densities and star depths are stored that light is marched through; half is right to 1 in
        700 and takes half of the memory.
    sparse : text, default auto
        Auto, always or never: whether pages of 16 x 16 x 16 voxels in which there is no dust and no gas are left out
        of the volumes; auto does so where volumes take 64 MiB or more and that saves a quarter.
    bounces : integer, default 1
        Times that starlight may scatter, 1000 for all; light of gas and background, which comes from everywhere,
        scatters one time less.
    exact_stars : integer, default all of up to 8; of more, one that sends over half of the light
        How many stars, the brightest, are marched one by one; the light of the others is gathered in cells, beyond
        the neighbourhood of each, by methods of nodes.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "method"

    def __init__(
        self,
        *,
        name: str | None = None,
        accuracy: float | None = None,
        count: int | None = None,
        domain: Sequence[str] | None = None,
        degree: int | None = None,
        range: float | None = None,
        criterion: str | None = None,
        steps: int | None = None,
        steps_per_voxel: float | None = None,
        star_depth_voxels: int | None = None,
        bake: int | None = None,
        volumes: str | None = None,
        sparse: str | None = None,
        bounces: int | None = None,
        exact_stars: int | None = None,
    ):
        super().__init__(
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
        )


class Animation(Table):
    """A key of the scene that changes from moment to moment: a star's temperature, the dust's scale, the white of the
    picture. Numbers go from key to key, with units and in lists too; whatever else can be said changes in steps.

    Parameters
    ----------
    of : text
        The key that changes, such as "star[0].temperature", the first star being number 0, or "display.white".
    times : list of times
        When it is what `values` say, ascending, such as ["0 s", "4 s"].
    values : list of values
        What it is then, each as the key itself would say it, all in one unit.
    interpolation : text, default bezier
        How values go from key to key.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
    """

    _path = "animation"

    def __init__(
        self,
        of: str,
        times: Sequence[Quantity] | Quantity,
        values: Sequence[Any] | Quantity,
        *,
        interpolation: str | None = None,
    ):
        super().__init__(of=of, times=times, values=values, interpolation=interpolation)


class Frames(Table):
    """Which moments of a scene that changes become frames; `barnard render --frames` renders them.

    Parameters
    ----------
    frames_per_second : number, default 30
        How many frames a second has.
    first_frame : integer, default 1
        The number of the frame that shows the first moment, 0 s.
    duration : time, default until the last key
        The time from the first frame to the last.
    shutter : angle, default 0 deg
        How long the shutter stays open, of 360 deg for as long as a frame lasts: what moves is blurred.
    shutter_moments : integer, default 8
        2 to 256: moments of which a frame with an open shutter is the mean.

    Raises
    ------
    SceneError
        Where a key or a unit is wrong; values out of their range are told when a scene is read.
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
        super().__init__(
            frames_per_second=frames_per_second,
            first_frame=first_frame,
            duration=duration,
            shutter=shutter,
            shutter_moments=shutter_moments,
        )


__all__ = ["Grid", "Fbm", "Sphere", "Box", "Plummer", "Shell", "Slab", "Turbulence", "Expression", "Stereo", "Keyframe", "CameraPath", "Camera", "perspective", "orthographic", "fisheye", "equirectangular", "cubemap", "Albedo", "Phase", "Dust", "Star", "StarTable", "Emission", "Gas", "StarField", "StarCatalogue", "Background", "Detail", "Spectrograph", "Band", "Glare", "Display", "Observation", "PointSpread", "Instrument", "Output", "Method", "Animation", "Frames"]
