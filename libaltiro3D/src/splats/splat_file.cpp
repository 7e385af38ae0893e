#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/json_reader.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace altiro3D {

namespace fs = std::filesystem;

SplatCollector::SplatCollector(std::uint64_t count, int degree) : fileDegree_(degree) {
    scene_.degree = std::min(degree, 3);
    scene_.splats.reserve(count);
    scene_.harmonics.reserve(count * 3 * coefficientsOf(scene_.degree));
}

namespace {

// Whether the numbers of a splat make sense.
template <class Number>
bool isUsable(const Splat& splat, const Number* harmonics, std::size_t count) {
    constexpr float kFarthest = 1e15F;
    constexpr float kLargest = 5e8F; // e^20
    constexpr double kBrightest = 1e6;
    const auto isColour = [](Number v) { return std::abs(static_cast<double>(v)) < kBrightest; };
    bool usable = splat.opacity >= 0;
    for (int i = 0; i < 3; ++i)
        usable = usable && std::abs(splat.centre[i]) < kFarthest && splat.radii[i] >= 0 &&
                 splat.radii[i] < kLargest &&
                 static_cast<double>(std::abs(splat.colour[i])) < kBrightest;
    const double length = cv::norm(splat.rotation);
    return usable && length > 1e-12 && length < 1e12 &&
           std::all_of(harmonics, harmonics + count, isColour);
}

} // namespace

void SplatCollector::add(Splat splat, const double* harmonics) {
    const std::size_t count = 3 * coefficientsOf(scene_.degree);
    if (!isUsable(splat, harmonics, count)) {
        ++leftOut_;
        return;
    }
    const double length = cv::norm(splat.rotation);
    for (float& q : splat.rotation.val)
        q = static_cast<float>(static_cast<double>(q) / length);
    splat.opacity = std::min(splat.opacity, 1.0F);
    scene_.splats.push_back(splat);
    scene_.harmonics.insert(scene_.harmonics.end(), harmonics, harmonics + count);
}

SplatScene SplatCollector::finish(const std::string& name, Notes* notes) {
    if (scene_.splats.empty())
        throw Error(ErrorCode::BadFormat, name,
                    leftOut_ == 0 ? "has no splats, expected at least one"
                                  : "has no splat whose numbers make sense, expected at least one");
    if (leftOut_ > 0)
        addNote(notes, NoteCode::LeftOut,
                std::to_string(leftOut_) + " of " +
                    std::to_string(leftOut_ + scene_.splats.size()) +
                    " splats are left out, as their numbers make no sense");
    if (fileDegree_ > scene_.degree)
        addNote(notes, NoteCode::LeftOut, "harmonics of degree 4 are left out");
    return std::move(scene_);
}

void turnAboutX(SplatScene& scene) {
    // how harmonics change as y and z do
    constexpr std::array<float, 15> kSigns = {-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1};
    for (Splat& splat : scene.splats)
        for (const int i : {1, 2}) {
            splat.centre[i] = -splat.centre[i];
            splat.rotation[i + 1] = -splat.rotation[i + 1];
        }
    const std::size_t count = coefficientsOf(scene.degree);
    for (std::size_t i = 0; i < scene.harmonics.size(); ++i)
        scene.harmonics[i] *= kSigns[i / 3 % count];
}

namespace {

// antimatter15's format: 32 bytes a splat, without a header.
SplatScene parseRows(std::string_view bytes, const std::string& name, Notes* notes) {
    constexpr std::size_t kRow = 32;
    const std::uint64_t count = bytes.size() / kRow;
    if (bytes.size() % kRow != 0)
        throw Error(ErrorCode::BadFormat, name,
                    "ends within splat " + std::to_string(count + 1) +
                        ", expected a whole file of 32 bytes for each splat");
    if (count > kMaxSplats)
        throw Error(ErrorCode::TooLarge, name,
                    "has " + std::to_string(count) + " splats, expected at most " +
                        std::to_string(kMaxSplats));
    SplatCollector collector(count, 0);
    for (std::uint64_t i = 0; i < count; ++i) {
        const char* const row = bytes.data() + i * kRow;
        Splat splat;
        std::memcpy(splat.centre.val, row, 12);
        std::memcpy(splat.radii.val, row + 12, 12);
        const auto code = [&](int at) {
            return static_cast<float>(static_cast<unsigned char>(row[at]));
        };
        for (int k = 0; k < 3; ++k)
            splat.colour[k] = code(24 + k) / 255;
        splat.opacity = code(27) / 255;
        for (int k = 0; k < 4; ++k)
            splat.rotation[k] = (code(28 + k) - 128) / 128;
        collector.add(splat, nullptr);
    }
    return collector.finish(name, notes);
}

// The camera in the middle of those that INRIA's training writes beside its result.
void takeCameras(const fs::path& file, SplatScene& scene, Notes* notes) {
    constexpr std::uintmax_t kMaxBytes = 1 << 24;
    std::error_code none;
    if (!fs::is_regular_file(file, none)) return;
    try {
        const Json list = parseJson(readFile(file, kMaxBytes), file.string(), "a list of cameras");
        const Json& one = list.at(list.size() / 2);
        using Place = std::array<double, 3>;
        const auto r = one.at("rotation").get<std::array<Place, 3>>(); // camera to world
        SplatCamera camera;
        camera.size = {one.at("width").get<int>(), one.at("height").get<int>()};
        camera.intrinsics = {one.at("fx").get<double>(), one.at("fy").get<double>(),
                             (camera.size.width - 1) / 2.0, (camera.size.height - 1) / 2.0};
        camera.eye = cv::Vec3d(one.at("position").get<Place>().data());
        camera.axes = {r[0][0], r[1][0], r[2][0], r[0][1], r[1][1],
                       r[2][1], r[0][2], r[1][2], r[2][2]};
        requireCamera(camera);
        scene.camera = camera;
    } catch (const std::exception& problem) {
        addNote(notes, NoteCode::LeftOut,
                file.filename().string() + " beside it is not used: " + oneLine(problem.what()));
    }
}

} // namespace

void requireSplats(const SplatScene& scene) {
    check(!scene.splats.empty() && scene.splats.size() <= kMaxSplats, "scene",
          "has " + std::to_string(scene.splats.size()) + " splats, expected 1 to 67108864");
    check(scene.degree >= 0 && scene.degree <= 3 &&
              scene.harmonics.size() == scene.splats.size() * 3 * coefficientsOf(scene.degree),
          "harmonics", "do not have the number that their degree needs");
}

void requireCamera(const SplatCamera& camera) {
    validate(Camera{camera.intrinsics});
    check(camera.size.width >= 1 && camera.size.height >= 1 && camera.size.width <= kMaxPicture &&
              camera.size.height <= kMaxPicture,
          "size", "is " + sizeText(camera.size) + ", expected sides of 1..16384 px");
    const cv::Matx33d turned = camera.axes * camera.axes.t() - cv::Matx33d::eye();
    check(cv::norm(turned) < 1e-3, "axes", "are not orthonormal, expected the rows of a rotation");
    check(cv::norm(camera.eye) < 1e15, "eye", "is too far away, expected a place in the scene");
}

bool isSplatFileName(const fs::path& path) {
    const std::string ending = lowerExtension(path);
    return ending == ".ply" || ending == ".splat" || ending == ".spz";
}

SplatScene parseSplats(const std::string& bytes, const fs::path& path, SplatAxes axes,
                       Notes* notes) {
    const std::string name = path.string();
    const std::string ending = lowerExtension(path);
    const auto refuse = [&](const char* problem) {
        throw Error(ErrorCode::Unsupported, name, problem);
    };
    if (startsWith(bytes, "PK") || ending == ".sog")
        refuse("is a scene of the format SOG, expected .ply, .splat or .spz (SuperSplat and "
               "splat-transform convert it)");
    if (ending == ".ksplat")
        refuse("is a scene of the format ksplat, expected .ply, .splat or .spz (SuperSplat and "
               "splat-transform convert it)");
    for (const char* const mesh : {".glb", ".gltf", ".obj", ".stl", ".fbx", ".usdz"})
        if (ending == mesh) refuse("is a mesh, expected Gaussian splats");
    const bool isSpz = startsWith(bytes, "\x1f\x8b") || startsWith(bytes, "NGSP");
    SplatScene scene =
        orOutOfMemory(name, "does not fit into memory, expected a smaller scene", [&] {
            if (startsWith(bytes, "ply")) return parsePly(bytes, name, notes);
            if (isSpz) return parseSpz(bytes, name, axes, notes);
            if (ending == ".splat") return parseRows(bytes, name, notes);
            throw Error(ErrorCode::BadFormat, name,
                        bytes.empty() ? "is empty, expected a scene of splats"
                                      : "is not a scene of splats, expected .ply, .splat or .spz");
        });
    if (!isSpz && axes == SplatAxes::Rub) turnAboutX(scene);
    return scene;
}

SplatScene readSplats(const fs::path& path, SplatAxes axes, Notes* notes) {
    constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 34;
    SplatScene scene = parseSplats(readFile(path, kMaxBytes), path, axes, notes);
    if (scene.camera || axes == SplatAxes::Rub || lowerExtension(path) != ".ply") return scene;
    const fs::path folder = path.parent_path();
    const bool isIteration = startsWith(folder.filename().string(), "iteration_");
    takeCameras(folder / "cameras.json", scene, notes);
    if (!scene.camera && isIteration) // as the training lays out its results
        takeCameras(folder / ".." / ".." / "cameras.json", scene, notes);
    return scene;
}

void writeSplats(const fs::path& path, const SplatScene& scene) {
    const std::string ending = lowerExtension(path);
    requireSplats(scene);
    const std::size_t count = 3 * coefficientsOf(scene.degree);
    for (std::size_t i = 0; i < scene.splats.size(); ++i)
        check(isUsable(scene.splats[i], scene.harmonics.data() + i * count, count), "scene",
              "has a splat, number " + std::to_string(i) +
                  ", whose numbers make no sense, expected those that readSplats() gives");
    check(ending == ".ply" || ending == ".spz", "path",
          "is \"" + path.string() + "\", expected a name that ends in .ply or .spz");
    writeFile(path, ending == ".ply" ? plyBytes(scene) : spzBytes(scene, path.string()));
}

} // namespace altiro3D
