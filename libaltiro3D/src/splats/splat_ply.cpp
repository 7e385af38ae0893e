#include "base/checks.hpp"
#include "base/srgb_light.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

namespace altiro3D {

namespace {

struct PlyType {
    const char* name;
    const char* longName;
    std::size_t bytes;
    double (*number)(const char* bytes);
};
template <class T>
constexpr PlyType plyType(const char* name, const char* longName) {
    return {name, longName, sizeof(T), [](const char* bytes) {
                T value;
                std::memcpy(&value, bytes, sizeof value);
                return static_cast<double>(value);
            }};
}
constexpr PlyType kTypes[] = {
    plyType<std::int8_t>("char", "int8"),    plyType<std::uint8_t>("uchar", "uint8"),
    plyType<std::int16_t>("short", "int16"), plyType<std::uint16_t>("ushort", "uint16"),
    plyType<std::int32_t>("int", "int32"),   plyType<std::uint32_t>("uint", "uint32"),
    plyType<float>("float", "float32"),      plyType<double>("double", "float64")};

struct PlyProperty {
    std::string name;
    const PlyType* type = nullptr;
    const PlyType* length = nullptr; // of a list; null: a number
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    bool has(std::string_view wanted) const {
        return std::any_of(properties.begin(), properties.end(), [&](const PlyProperty& property) {
            return property.name == wanted && property.length == nullptr;
        });
    }
};

// A number that is wanted of each row.
struct PlyField {
    std::string name;
    std::optional<double> otherwise = std::nullopt; // if the file has none; empty: it must have one
};
using PlyFields = std::vector<PlyField>;
using Row = std::vector<double>; // of wanted numbers, and one more

// A file, read row by row in the order of its elements.
class PlyFile {
  public:
    PlyFile(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {
        readHeader();
    }

    std::vector<PlyElement> elements;
    bool isAntialiased = false;

    const PlyElement* find(std::string_view name) const {
        const auto found = std::find_if(elements.begin(), elements.end(),
                                        [&](const PlyElement& e) { return e.name == name; });
        return found == elements.end() ? nullptr : &*found;
    }

    [[noreturn]] void refuse(const std::string& problem,
                             ErrorCode code = ErrorCode::BadFormat) const {
        throw Error(code, name_, problem);
    }

    // Passes the wanted numbers of each row of the next element.
    // @param mayEnd the file may end before the last one
    template <class Take>
    void rows(const PlyElement& element, const PlyFields& fields, const Take& take,
              bool mayEnd = false) {
        Row row(fields.size() + 1); // the last one for all that is not wanted
        for (std::size_t k = 0; k < fields.size(); ++k)
            row[k] = fields[k].otherwise.value_or(0);
        std::vector<double*> places; // of its properties
        for (const PlyProperty& property : element.properties) {
            std::size_t k = 0;
            while (k < fields.size() &&
                   (fields[k].name != property.name || property.length != nullptr))
                ++k;
            const bool isTaken = std::count(places.begin(), places.end(), &row[k]) > 0;
            places.push_back(isTaken ? &row.back() : &row[k]); // the first of a name counts
        }
        for (std::uint64_t i = 0; i < element.count && !places.empty(); ++i) {
            if (readRow(element, places)) {
                take(row);
            } else if (mayEnd) {
                return;
            } else {
                tellCut(element, i);
            }
        }
    }

    // Refuses a file that is too short for an element, before memory is allocated for it.
    void requireRows(const PlyElement& element) const {
        if (element.count > kMaxSplats)
            refuse("has " + std::to_string(element.count) + " rows of \"" +
                       shortened(element.name) + "\", expected at most " +
                       std::to_string(kMaxSplats),
                   ErrorCode::TooLarge);
        std::uint64_t least = 0; // bytes of a row; a number of a text takes two
        for (const PlyProperty& property : element.properties)
            least +=
                isText_ ? 2 : (property.length == nullptr ? property.type : property.length)->bytes;
        // the last number of a text may take one byte
        const std::uint64_t there = bytes_.size() - at_ + (isText_ ? 1 : 0);
        least = std::max<std::uint64_t>(least, 1);
        if (there / least < element.count) tellCut(element, there / least);
    }

  private:
    [[noreturn]] void tellCut(const PlyElement& element, std::uint64_t there) const {
        refuse("ends after " + std::to_string(there) + " of " + std::to_string(element.count) +
               (element.name == "vertex" ? " splats" : " rows") + ", expected a whole file");
    }

    std::string line() {
        constexpr std::size_t kMaxHeader = 1 << 17;
        const std::size_t end = bytes_.find('\n', at_);
        if (end > kMaxHeader) // or npos
            refuse("has no end of its header, expected a .ply file");
        std::string text(bytes_.substr(at_, end - at_));
        at_ = end + 1;
        if (endsWith(text, "\r")) text.pop_back();
        return text;
    }

    const PlyType* typeOf(const std::string& word) const {
        for (const PlyType& type : kTypes)
            if (word == type.name || word == type.longName) return &type;
        refuse("has numbers of type \"" + shortened(word) +
               "\", expected a type of .ply files, such as float");
    }

    std::uint64_t countOf(const std::string& word) const {
        std::uint64_t count = 0;
        const char* const end = word.data() + word.size();
        const auto [last, error] = std::from_chars(word.data(), end, count);
        if (error != std::errc() || last != end)
            refuse("has \"" + shortened(word) + "\" as a number of rows, expected a number");
        return count;
    }

    void readHeader() {
        if (line() != "ply") refuse("does not begin with \"ply\", expected a .ply file");
        bool hasFormat = false;
        for (std::string text = line(); text != "end_header"; text = line()) {
            std::istringstream stream(text);
            const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
            const std::string kind = words.empty() ? "comment" : words[0];
            const std::size_t count = words.size();
            const bool isList = count == 5 && words[1] == "list";
            if (kind == "format" && count == 3) {
                isText_ = words[1] == "ascii";
                isSwapped_ = words[1] == "binary_big_endian";
                hasFormat = isText_ || isSwapped_ || words[1] == "binary_little_endian";
            } else if (kind == "element" && count == 3) {
                elements.push_back({words[1], countOf(words[2]), {}});
            } else if (kind == "property" && (count == 3 || isList) && !elements.empty()) {
                elements.back().properties.push_back(
                    {words.back(), typeOf(words[count - 2]), isList ? typeOf(words[2]) : nullptr});
            } else if (kind == "comment" || kind == "obj_info") {
                const std::string said = count == 3 ? words[1] + " " + words[2] : "";
                if (said == "SplatRenderMode: mip" || said == "antialiased 1") isAntialiased = true;
            } else {
                refuse("has \"" + shortened(text) + "\" in its header, expected a .ply file");
            }
        }
        if (!hasFormat) refuse("has no known format line, expected a .ply file");
    }

    // @return false if the file ends before
    bool readRow(const PlyElement& element, const std::vector<double*>& places) {
        for (std::size_t k = 0; k < places.size(); ++k) {
            const PlyProperty& property = element.properties[k];
            double length = 1;
            if (property.length != nullptr && !next(*property.length, length)) return false;
            auto entries = length >= 1 ? static_cast<std::uint64_t>(std::min(length, 1e18)) : 0;
            for (; entries > 0; --entries)
                if (!next(*property.type, *places[k])) return false;
        }
        return true;
    }

    bool next(const PlyType& type, double& value) {
        if (isText_) return nextWord(value);
        if (bytes_.size() - at_ < type.bytes) return false;
        char raw[8];
        std::memcpy(raw, bytes_.data() + at_, type.bytes);
        at_ += type.bytes;
        if (isSwapped_) std::reverse(raw, raw + type.bytes);
        value = type.number(raw);
        return true;
    }

    bool nextWord(double& value) {
        const std::size_t begin = bytes_.find_first_not_of(" \t\r\n", at_);
        if (begin == std::string_view::npos) return false;
        at_ = std::min(bytes_.find_first_of(" \t\r\n", begin), bytes_.size());
        const std::string word(bytes_.substr(begin, at_ - begin));
        const char* const wordEnd = word.data() + word.size();
#ifdef __cpp_lib_to_chars
        const auto [end, error] = std::from_chars(word.data(), wordEnd, value);
        const bool isNumber = error == std::errc() && end == wordEnd;
#else
        char* end = nullptr;
        value = std::strtod(word.c_str(), &end);
        const bool isNumber = end == wordEnd;
#endif
        if (!isNumber)
            refuse("has \"" + shortened(word) + "\" among its numbers, expected numbers");
        return true;
    }

    std::string_view bytes_;
    const std::string& name_;
    std::size_t at_ = 0;
    bool isText_ = false;
    bool isSwapped_ = false;
};

// Adds red, green and blue of each coefficient; files have all of red first. @return the degree
int addHarmonics(const PlyFile& file, const PlyElement& element, PlyFields& fields) {
    const auto name = [](std::size_t i) { return "f_rest_" + std::to_string(i); };
    std::size_t count = 0;
    while (element.has(name(count)))
        ++count;
    int degree = 0;
    while (degree < 5 && 3 * coefficientsOf(degree) != count)
        ++degree;
    if (degree == 5)
        file.refuse("has " + std::to_string(count) +
                    " coefficients of harmonics, expected 0, 9, 24, 45 or 72");
    for (std::size_t i = 0; i < count; ++i)
        fields.push_back({name(i % 3 * (count / 3) + i / 3)});
    return degree;
}

bool hasAll(const PlyElement& element, const PlyFields& fields) {
    return std::all_of(fields.begin(), fields.end(), [&](const PlyField& field) {
        return field.otherwise || element.has(field.name);
    });
}

SplatCollector readPlain(PlyFile& file, const PlyElement& vertex) {
    constexpr double kFlat = -std::numeric_limits<double>::infinity(); // discs have two radii
    PlyFields fields = {{"x"},      {"y"},       {"z"},       {"f_dc_0"},  {"f_dc_1"},
                        {"f_dc_2"}, {"opacity"}, {"scale_0"}, {"scale_1"}, {"scale_2", kFlat},
                        {"rot_0"},  {"rot_1"},   {"rot_2"},   {"rot_3"}};
    if (!hasAll(vertex, fields)) {
        const PlyElement* const faces = file.find("face");
        file.refuse(faces != nullptr && faces->count > 0 ? "is a mesh, expected Gaussian splats"
                    : !vertex.has("opacity")
                        ? "is a cloud of points, expected Gaussian splats"
                        : "lacks fields of splats, expected x, f_dc_0, opacity, scale_0, rot_0 and "
                          "those that follow them",
                    ErrorCode::Unsupported);
    }
    const std::size_t count = fields.size();
    SplatCollector collector(vertex.count, addHarmonics(file, vertex, fields));
    file.rows(vertex, fields, [&](const Row& row) {
        const auto at = [&](std::size_t k) { return static_cast<float>(row[k]); };
        Splat splat;
        splat.centre = {at(0), at(1), at(2)};
        splat.colour = {displayValue(at(3)), displayValue(at(4)), displayValue(at(5))};
        splat.opacity = opacityOf(at(6));
        splat.radii = {radiusOf(at(7)), radiusOf(at(8)), radiusOf(at(9))};
        splat.rotation = {at(10), at(11), at(12), at(13)};
        collector.add(splat, &row[count]);
    });
    return collector;
}

// PlayCanvas' compressed form: numbers of 8 to 11 bits between the limits of 256 splats, which are
// the lowest x y z, scale x y z, r g b, then the highest ones.
using Limits = std::vector<Row>;

Limits readLimits(PlyFile& file, const PlyElement& element) {
    PlyFields fields;
    for (const std::string& end : {std::string("min_"), std::string("max_")}) {
        for (const char* const name : {"x", "y", "z", "scale_x", "scale_y", "scale_z"})
            fields.push_back({end + name});
        for (const char* const name : {"r", "g", "b"}) // old files have none
            fields.push_back({end + name, end == "min_" ? 0 : 1});
    }
    if (!hasAll(element, fields))
        file.refuse("lacks the limits of its chunks, expected a compressed .ply file");
    Limits limits;
    file.rows(element, fields, [&](const Row& row) { limits.push_back(row); });
    return limits;
}

double bitsOf(std::uint32_t packed, unsigned shift, unsigned count) {
    const std::uint32_t most = (1U << count) - 1;
    return static_cast<double>(packed >> shift & most) / most;
}

SplatCollector readCompressed(PlyFile& file, const PlyElement& vertex, const Limits& chunks) {
    const PlyFields fields = {
        {"packed_position"}, {"packed_rotation"}, {"packed_scale"}, {"packed_color"}};
    if (!hasAll(vertex, fields))
        file.refuse("lacks packed fields, expected a compressed .ply file");
    if (chunks.size() < (vertex.count + 255) / 256)
        file.refuse("has " + std::to_string(chunks.size()) +
                    " chunks, expected one for 256 splats");
    std::vector<Splat> splats;
    splats.reserve(vertex.count);
    file.rows(vertex, fields, [&](const Row& row) {
        const auto packed = [&](std::size_t k) {
            return row[k] >= 0 && row[k] <= UINT32_MAX ? static_cast<std::uint32_t>(row[k]) : 0U;
        };
        const Row& limits = chunks[splats.size() / 256];
        const auto between = [&](std::size_t k, double t) {
            return static_cast<float>(limits[k] * (1 - t) + limits[9 + k] * t);
        };
        Splat& splat = splats.emplace_back();
        for (unsigned k = 0; k < 3; ++k) {
            constexpr unsigned kShift[] = {21, 11, 0};
            constexpr unsigned kBits[] = {11, 10, 11};
            const auto i = static_cast<int>(k);
            splat.centre[i] = between(k, bitsOf(packed(0), kShift[k], kBits[k]));
            splat.radii[i] = radiusOf(between(3 + k, bitsOf(packed(2), kShift[k], kBits[k])));
            splat.colour[i] = between(6 + k, bitsOf(packed(3), 24 - 8 * k, 8));
        }
        splat.rotation = smallestThree(packed(1), [](std::uint32_t code) {
            return (bitsOf(code, 0, 10) - 0.5) * std::sqrt(2.0);
        });
        splat.opacity = static_cast<float>(bitsOf(packed(3), 0, 8));
    });
    const PlyElement* const sh = file.find("sh");
    PlyFields rest;
    const int degree = sh == nullptr ? 0 : addHarmonics(file, *sh, rest);
    SplatCollector collector(vertex.count, degree);
    std::size_t i = 0;
    if (degree > 0) {
        file.requireRows(*sh);
        file.rows(*sh, rest, [&](Row& row) {
            for (double& value : row) // 0 and 255 are the ends, others the middle of their interval
                value = 8 * ((value == 0 ? 0 : value == 255 ? 1 : (value + 0.5) / 256) - 0.5);
            if (i < splats.size()) collector.add(splats[i++], row.data());
        });
    }
    const Row none(rest.size());
    while (i < splats.size())
        collector.add(splats[i++], none.data());
    return collector;
}

// The camera in the elements of SHARP. @param values of each element
void takeCamera(const std::map<std::string, Row>& values, SplatScene& scene, Notes* notes) {
    const auto of = [&](const char* name, std::size_t count) -> const double* {
        const auto found = values.find(name);
        return found != values.end() && found->second.size() >= count ? found->second.data()
                                                                      : nullptr;
    };
    const double* const lens = of("intrinsic", 4);
    const double* const size = of("image_size", 2);
    if (lens == nullptr || size == nullptr) return;
    SplatCamera camera;
    const auto isSide = [](double side) { return side >= 1 && side <= 1e5; };
    if (isSide(size[0]) && isSide(size[1]))
        camera.size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
    camera.intrinsics = {lens[0], lens[1], lens[2], lens[3]};
    if (of("intrinsic", 9) != nullptr) // a matrix
        camera.intrinsics = {lens[0], lens[4], lens[2], lens[5]};
    camera.intrinsics.cx -= 0.5; // counted from the corner of a px
    camera.intrinsics.cy -= 0.5;
    if (const double* const values12 = of("extrinsic", 12)) {
        const cv::Matx34d pose(values12);
        camera.axes = pose.get_minor<3, 3>(0, 0);
        camera.eye = -(camera.axes.t() * cv::Vec3d(pose(0, 3), pose(1, 3), pose(2, 3)));
    }
    try {
        requireCamera(camera);
    } catch (const Error& problem) {
        addNote(notes, NoteCode::Doubtful,
                "the camera in the file is not used: " + std::string(problem.what()));
        return;
    }
    scene.camera = camera;
    const double* const disparity = of("disparity", 2);
    const double sum = disparity == nullptr ? 0 : disparity[0] + disparity[1];
    if (sum > 1e-9 && sum < 1e9) scene.focusDistance = 2 / sum;
}

} // namespace

SplatScene parsePly(std::string_view bytes, const std::string& name, Notes* notes) {
    PlyFile file(bytes, name);
    const PlyElement* const vertex = file.find("vertex");
    if (vertex == nullptr) file.refuse("has no vertices, expected splats");
    Limits chunks;
    std::map<std::string, Row> values;
    std::optional<SplatScene> scene;
    for (const PlyElement& element : file.elements) {
        if (&element == vertex) {
            file.requireRows(element);
            scene = (file.find("chunk") != nullptr ? readCompressed(file, element, chunks)
                                                   : readPlain(file, element))
                        .finish(name, notes);
        } else if (element.name == "chunk" && !scene) {
            file.requireRows(element);
            chunks = readLimits(file, element);
        } else if (element.name != "sh") {
            constexpr std::size_t kMost = 64; // values of a camera
            Row& all = values[element.name];
            PlyFields first;
            if (!element.properties.empty()) first.push_back({element.properties.front().name});
            const auto take = [&](const Row& row) {
                if (all.size() < kMost) all.push_back(row.front());
            };
            file.rows(element, first, take, scene.has_value());
        }
    }
    scene->isAntialiased = file.isAntialiased;
    takeCamera(values, *scene, notes);
    const auto space = values.find("color_space");
    if (space != values.end() && !space->second.empty() && space->second[0] == 1) {
        for (Splat& splat : scene->splats) // as public viewers blend them
            for (float& value : splat.colour.val)
                value = static_cast<float>(srgbOf(static_cast<double>(std::max(value, 0.0F))));
    }
    return std::move(*scene);
}

std::string plyBytes(const SplatScene& scene) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    std::string camera; // the elements of SHARP, of one property each, of their own name
    const auto addElement = [&](const std::string& name, const char* type, const auto& values) {
        header += "element " + name + " " + std::to_string(values.size()) + "\nproperty " + type +
                  " " + name + "\n";
        for (const auto value : values)
            addBytes(camera, value);
    };
    header += "element vertex " + std::to_string(scene.splats.size()) + "\n";
    const std::size_t rest = 3 * coefficientsOf(scene.degree);
    std::vector<std::string> names = {"x",  "y",      "z",      "nx",    "ny",
                                      "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
    for (std::size_t i = 0; i < rest; ++i)
        names.push_back("f_rest_" + std::to_string(i));
    for (const char* const name :
         {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        names.emplace_back(name);
    for (const std::string& name : names)
        header += "property float " + name + "\n";
    if (scene.camera) {
        const auto& [size, lens, axes, eye] = *scene.camera;
        cv::Matx44f pose = cv::Matx44f::eye();
        const cv::Vec3d shift = -(axes * eye);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 4; ++c)
                pose(r, c) = static_cast<float>(c < 3 ? axes(r, c) : shift[r]);
        const cv::Matx33f matrix =
            cv::Matx33d(lens.fx, 0, lens.cx + 0.5, 0, lens.fy, lens.cy + 0.5, 0, 0, 1);
        addElement("extrinsic", "float", std::vector<float>(pose.val, pose.val + 16));
        addElement("intrinsic", "float", std::vector<float>(matrix.val, matrix.val + 9));
        addElement("image_size", "uint", std::vector<std::int32_t>{size.width, size.height});
        if (scene.focusDistance > 0)
            addElement("disparity", "float",
                       std::vector<float>(2, static_cast<float>(1 / scene.focusDistance)));
    }
    std::string bytes = header + "end_header\n";
    bytes.reserve(bytes.size() + scene.splats.size() * 4 * names.size() + camera.size());
    for (std::size_t i = 0; i < scene.splats.size(); ++i) {
        const Splat& splat = scene.splats[i];
        addBytes(bytes, splat.centre.val);
        addBytes(bytes, cv::Vec3f().val);
        for (const float value : splat.colour.val)
            addBytes(bytes, static_cast<float>(harmonicOf(value)));
        for (std::size_t k = 0; k < rest; ++k) // all of red first
            addBytes(bytes, scene.harmonics[i * rest + 3 * (k % (rest / 3)) + k / (rest / 3)]);
        const auto opacity = static_cast<double>(splat.opacity);
        addBytes(bytes, static_cast<float>(std::log(opacity / (1 - opacity))));
        for (const float radius : splat.radii.val)
            addBytes(bytes, static_cast<float>(std::log(static_cast<double>(radius))));
        addBytes(bytes, splat.rotation.val);
    }
    return bytes + camera;
}

} // namespace altiro3D
