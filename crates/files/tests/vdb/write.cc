// Writes the files of vdb.zip beside this program; tests/vdb.rs knows the same formulas.
//
//   g++ -O1 write.cc -lopenvdb -lImath-3_1 -ltbb -o write && mkdir vdb && ./write vdb && (cd vdb && zip -9 ../../vdb.zip *)
//
// Made with OpenVDB 10.0.1 (Debian 12), which is built without zlib: zip.py packs the *_zip files, halved_zip* are left out.

#include <openvdb/io/Stream.h>
#include <openvdb/math/Maps.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <fstream>
#include <string>

using namespace openvdb;

// What a voxel holds: halves hold it exactly.
static double value(int i, int j, int k) { return ((3 * i + 5 * j + 7 * k) % 61 + 1) / 8.0; }

// The voxels from 2 to 17 along x, to 11 along y and z, two of three active; the others have a value of `inactive`
// kinds: the background, one, two, or each its own. Beside them stands a tile of 8 voxels.
template <typename G>
typename G::Ptr cloud(int inactive, double background = 0) {
    auto grid = G::create(background);
    auto set = grid->getAccessor();
    for (int i = 2; i < 18; ++i)
        for (int j = 2; j < 12; ++j)
            for (int k = 2; k < 12; ++k) {
                if ((i + 2 * j + 3 * k) % 3 != 0)
                    set.setValue(Coord(i, j, k), value(i, j, k));
                else if (inactive > 0)
                    set.setValueOff(Coord(i, j, k), inactive == 1 ? 0.25 : inactive == 2 ? (i < 9 ? 0.25 : 0.5) : value(i, j, k) / 2);
            }
    grid->fill(CoordBBox(Coord(24, 8, 8), Coord(31, 15, 15)), 2.0, true);
    grid->setName("density");
    grid->setGridClass(GRID_FOG_VOLUME);
    return grid;
}

// Where a step along each axis goes, and where the voxel 0, 0, 0 is.
static Mat4d affine(Mat3d axes, Vec3d origin) {
    Mat4d matrix;
    matrix.setIdentity();
    matrix.setMat3(axes);
    matrix.setTranslation(origin);
    return matrix;
}

static std::string folder;

static void save(const std::string& name, GridCPtrVec grids, uint32_t compression = io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK) {
    io::File file(folder + "/" + name + ".vdb");
    file.setCompression(compression);
    file.write(grids);
}

template <typename G>
static void combinations(const std::string& name, bool half) {
    const std::pair<const char*, uint32_t> packers[] = {{"plain", 0}, {"zip", io::COMPRESS_ZIP}, {"blosc", io::COMPRESS_BLOSC}};
    for (auto [packer, flag] : packers)
        for (uint32_t mask : {0u, uint32_t(io::COMPRESS_ACTIVE_MASK)}) {
            auto grid = cloud<G>(0);
            grid->setSaveFloatAsHalf(half);
            save(name + "_" + packer + (mask ? "_mask" : ""), {grid}, flag | mask);
        }
    for (int inactive : {1, 2, 3}) {
        auto grid = cloud<G>(inactive);
        grid->setSaveFloatAsHalf(half);
        save(name + "_inactive" + std::to_string(inactive), {grid});
    }
}

int main(int, char** arguments) {
    initialize();
    folder = arguments[1];
    combinations<FloatGrid>("float", false);
    combinations<FloatGrid>("half", true);
    combinations<DoubleGrid>("double", false);
    combinations<DoubleGrid>("halved", true);

    auto mapped = [](const std::string& name, math::MapBase::Ptr map) {
        auto grid = cloud<FloatGrid>(0);
        grid->setTransform(math::Transform::Ptr(new math::Transform(map)));
        save("map_" + name, {grid});
    };
    mapped("uniform", math::MapBase::Ptr(new math::UniformScaleMap(0.5)));
    mapped("scale", math::MapBase::Ptr(new math::ScaleMap(Vec3d(0.5, 1, 2))));
    mapped("translate", math::MapBase::Ptr(new math::TranslationMap(Vec3d(10, 20, 30))));
    mapped("uniform_translate", math::MapBase::Ptr(new math::UniformScaleTranslateMap(0.5, Vec3d(10, 20, 30))));
    mapped("scale_translate", math::MapBase::Ptr(new math::ScaleTranslateMap(Vec3d(0.5, 1, 2), Vec3d(10, 20, 30))));
    // x to y, y to z, z to -x.
    mapped("turned", math::MapBase::Ptr(new math::AffineMap(affine(Mat3d(0., .5, 0., 0., 0., 1., -2., 0., 0.), Vec3d(10, 20, 30)))));
    mapped("rotated", math::MapBase::Ptr(new math::AffineMap(affine(Mat3d(.6, .8, 0., -.8, .6, 0., 0., 0., 1.), Vec3d(0, 0, 0)))));
    mapped("sheared", math::MapBase::Ptr(new math::AffineMap(affine(Mat3d(1., .3, 0., 0., 1., 0., 0., 0., 1.), Vec3d(0, 0, 0)))));
    mapped("frustum", math::MapBase::Ptr(new math::NonlinearFrustumMap(BBoxd(Vec3d(0), Vec3d(31)), 0.5, 1.0)));

    auto level_set = cloud<FloatGrid>(0, 3);
    level_set->setGridClass(GRID_LEVEL_SET);
    save("level_set", {level_set});
    auto vectors = Vec3SGrid::create();
    vectors->setName("velocity");
    vectors->getAccessor().setValue(Coord(1, 2, 3), Vec3s(1, 2, 3));
    save("vectors", {vectors});
    auto points = points::PointDataGrid::create();
    points->setName("points");
    save("points", {points});
    auto whole = Int32Grid::create();
    whole->setName("id");
    whole->getAccessor().setValue(Coord(1, 2, 3), 7);
    save("integers", {whole});
    save("empty", {FloatGrid::create()});
    save("background", {cloud<FloatGrid>(0, 0.125)});

    auto temperature = FloatGrid::create();
    temperature->setName("temperature");
    temperature->fill(CoordBBox(Coord(0), Coord(3)), 5000.f);
    // A copy shares the tree, and is written as an instance of the first.
    auto twin = FloatGrid::create(*cloud<FloatGrid>(0));
    auto first = cloud<FloatGrid>(0);
    auto second = first->copy();
    second->setName("moved");
    second->setTransform(math::Transform::createLinearTransform(0.25));
    save("several", {vectors, temperature, first, second});
    auto same = temperature->deepCopy();
    same->setName("density");
    save("one_name", {first, same});

    // Larger nodes: a tile of 128 voxels, and voxels on both sides of zero.
    auto large = FloatGrid::create();
    large->setName("density");
    large->fill(CoordBBox(Coord(128, -128, -128), Coord(255, -1, -1)), 1.5f);
    large->getAccessor().setValue(Coord(-1, -1, -1), 0.5f);
    large->getAccessor().setValue(Coord(0, 0, 0), 0.75f);
    save("large", {large});
    auto root = FloatGrid::create();
    root->setName("density");
    root->tree().root().addTile(Coord(4096, 0, 0), 3.0f, true);
    root->getAccessor().setValue(Coord(0, 0, 0), 0.75f);
    save("root_tile", {root});

    std::ofstream out(folder + "/streamed.vdb", std::ios_base::binary);
    io::Stream(out).write(GridCPtrVec{cloud<FloatGrid>(0)});
    return 0;
}
