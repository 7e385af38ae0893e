#include "base/checks.hpp"
#include "base/srgb_light.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <map>

namespace altiro3D {

namespace {

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float, Double };

struct PlyTypeName {
    const char* name;
    const char* longName;
    PlyType type;
    std::size_t bytes;
};
constexpr PlyTypeName kTypes[] = {
    {"char", "int8", PlyType::Int8, 1},      {"uchar", "uint8", PlyType::UInt8, 1},
    {"short", "int16", PlyType::Int16, 2},   {"ushort", "uint16", PlyType::UInt16, 2},
    {"int", "int32", PlyType::Int32, 4},     {"uint", "uint32", PlyType::UInt32, 4},
    {"float", "float32", PlyType::Float, 4}, {"double", "float64", PlyType::Double, 8}};

struct PlyProperty {
    std::string name;
    const PlyTypeName* type = nullptr;
    const PlyTypeName* length = nullptr; // of a list; null: a number
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    // Its place among the numbers of a row; -1: there is none.
    int column(std::string_view wanted) const {
        for (std::size_t i = 0; i < properties.size(); ++i)
            if (properties[i].name == wanted && properties[i].length == nullptr)
                return static_cast<int>(i);
        return -1;
    }
    bool hasLists() const {
        return std::any_of(properties.begin(), properties.end(),
                           [](const PlyProperty& p) { return p.length != nullptr; });
    }
    std::uint64_t rowBytes() const {
        std::uint64_t sum = 0;
        for (const PlyProperty& property : properties)
            sum += property.type->bytes;
        return sum;
    }
};

template <class T>
double numberOf(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}

double numberOf(PlyType type, const char* bytes) {
    switch (type) {
    case PlyType::Int8:
        return numberOf<std::int8_t>(bytes);
    case PlyType::UInt8:
        return numberOf<std::uint8_t>(bytes);
    case PlyType::Int16:
        return numberOf<std::int16_t>(bytes);
    case PlyType::UInt16:
        return numberOf<std::uint16_t>(bytes);
    case PlyType::Int32:
        return numberOf<std::int32_t>(bytes);
    case PlyType::UInt32:
        return numberOf<std::uint32_t>(bytes);
    case PlyType::Float:
        return numberOf<float>(bytes);
    case PlyType::Double:
        break;
    }
    return numberOf<double>(bytes);
}

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

    [[noreturn]] void refuse(ErrorCode code, const std::string& problem) const {
        throw Error(code, name_, problem);
    }

    // Passes the rows of the next element, a number for each property, 0 for a list.
    // @return the rows that are there
    template <class Take>
    std::uint64_t rows(const PlyElement& element, const Take& take) {
        std::vector<double> row(element.properties.size());
        if (row.empty()) return element.count;
        for (std::uint64_t i = 0; i < element.count; ++i) {
            for (std::size_t k = 0; k < row.size(); ++k) {
                const PlyProperty& property = element.properties[k];
                row[k] = 0;
                if (property.length == nullptr) {
                    if (!next(*property.type, row[k])) return i;
                    continue;
                }
                double length = 0;
                double ignored = 0;
                if (!next(*property.length, length)) return i;
                const double most = static_cast<double>(bytes_.size()); // more are not there
                const auto entries =
                    static_cast<std::uint64_t>(length > 0 ? std::min(length, most) : 0);
                for (std::uint64_t entry = 0; entry < entries; ++entry)
                    if (!next(*property.type, ignored)) return i;
            }
            take(row);
        }
        return element.count;
    }

    // Refuses a file that is too short for an element, before memory is allocated for it.
    void requireRows(const PlyElement& element) const {
        if (element.count > kMaxSplats)
            refuse(ErrorCode::TooLarge, "has " + std::to_string(element.count) + " rows of \"" +
                                            shortened(element.name) + "\", expected at most " +
                                            std::to_string(kMaxSplats));
        // a number of a text takes two characters, the last one perhaps one
        const std::uint64_t there = bytes_.size() - at_ + (isText_ ? 1 : 0);
        const std::uint64_t row = std::max<std::uint64_t>(
            isText_ ? 2 * element.properties.size() : element.rowBytes(), 1);
        if (!element.hasLists() && there / row < element.count) tellCut(element, there / row);
    }

    [[noreturn]] void tellCut(const PlyElement& element, std::uint64_t there) const {
        refuse(ErrorCode::BadFormat,
               "ends after " + std::to_string(there) + " of " + std::to_string(element.count) +
                   (element.name == "vertex" ? " splats" : " rows") + ", expected a whole file");
    }

  private:
    std::string_view line() {
        const std::size_t end = bytes_.find('\n', at_);
        if (end > kMaxHeader) // or npos
            refuse(ErrorCode::BadFormat, "has no end of its header, expected a .ply file");
        std::string_view text = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
        return text;
    }

    static std::vector<std::string> words(std::string_view text) {
        std::vector<std::string> result;
        while (!text.empty()) {
            const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
            if (end > 0) result.emplace_back(text.substr(0, end));
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        return result;
    }

    const PlyTypeName* typeOf(const std::string& word) const {
        for (const PlyTypeName& type : kTypes)
            if (word == type.name || word == type.longName) return &type;
        refuse(ErrorCode::BadFormat, "has numbers of type \"" + shortened(word) +
                                         "\", expected a type of .ply files, such as float");
    }

    void readHeader() {
        if (line() != "ply")
            refuse(ErrorCode::BadFormat, "does not begin with \"ply\", expected a .ply file");
        bool hasFormat = false;
        for (std::string_view text = line(); text != "end_header"; text = line()) {
            const std::vector<std::string> word = words(text);
            if (word.size() == 3 && word[0] == "format") {
                hasFormat = true;
                isText_ = word[1] == "ascii";
                isSwapped_ = word[1] == "binary_big_endian";
                hasFormat = isText_ || isSwapped_ || word[1] == "binary_little_endian";
            } else if (word.size() == 3 && word[0] == "element") {
                PlyElement element{word[1], 0, {}};
                const char* const end = word[2].data() + word[2].size();
                const auto [last, error] = std::from_chars(word[2].data(), end, element.count);
                if (error != std::errc() || last != end)
                    refuse(ErrorCode::BadFormat, "has \"" + shortened(word[2]) +
                                                     "\" as a number of rows, expected a number");
                elements.push_back(element);
            } else if (word.size() == 3 && word[0] == "property" && !elements.empty()) {
                elements.back().properties.push_back({word[2], typeOf(word[1]), nullptr});
            } else if (word.size() == 5 && word[0] == "property" && word[1] == "list" &&
                       !elements.empty()) {
                elements.back().properties.push_back({word[4], typeOf(word[3]), typeOf(word[2])});
            } else if (!word.empty() && (word[0] == "comment" || word[0] == "obj_info")) {
                const bool isMode = word.size() == 3 && word[1] == "SplatRenderMode:";
                const bool isFlag = word.size() == 3 && word[1] == "antialiased";
                if ((isMode && word[2] == "mip") || (isFlag && word[2] == "1"))
                    isAntialiased = true;
            } else if (!word.empty()) {
                refuse(ErrorCode::BadFormat, "has \"" + shortened(std::string(text)) +
                                                 "\" in its header, expected a .ply file");
            }
        }
        if (!hasFormat)
            refuse(ErrorCode::BadFormat, "has no known format line, expected a .ply file");
    }

    bool next(const PlyTypeName& type, double& value) {
        if (isText_) return nextWord(value);
        if (bytes_.size() - at_ < type.bytes) return false;
        char raw[8];
        std::memcpy(raw, bytes_.data() + at_, type.bytes);
        at_ += type.bytes;
        if (isSwapped_) std::reverse(raw, raw + type.bytes);
        value = numberOf(type.type, raw);
        return true;
    }

    bool nextWord(double& value) {
        const std::size_t begin = bytes_.find_first_not_of(" \t\r\n", at_);
        if (begin == std::string_view::npos) return false;
        at_ = std::min(bytes_.find_first_of(" \t\r\n", begin), bytes_.size());
        const std::string_view word = bytes_.substr(begin, at_ - begin);
        bool isNumber = false;
#ifdef __cpp_lib_to_chars
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        isNumber = error == std::errc() && end == word.data() + word.size();
#else
        const std::string text(word);
        char* end = nullptr;
        value = std::strtod(text.c_str(), &end);
        isNumber = end == text.c_str() + text.size();
#endif
        if (!isNumber)
            refuse(ErrorCode::BadFormat, "has \"" + shortened(std::string(word)) +
                                             "\" among its "
                                             "numbers, expected numbers");
        return true;
    }

    static constexpr std::size_t kMaxHeader = 1 << 17;
    std::string_view bytes_;
    const std::string& name_;
    std::size_t at_ = 0;
    bool isText_ = false;
    bool isSwapped_ = false;
};

using Row = std::vector<double>;

float cell(const Row& row, int column) {
    return column < 0 ? 0 : static_cast<float>(row[static_cast<std::size_t>(column)]);
}

// The number of f_rest_... as a degree.
int degreeOf(const PlyFile& file, const PlyElement& element) {
    std::size_t count = 0;
    while (element.column("f_rest_" + std::to_string(count)) >= 0)
        ++count;
    for (int degree = 0; degree <= 4; ++degree)
        if (count == 3 * coefficientsOf(degree)) return degree;
    file.refuse(ErrorCode::BadFormat,
                "has " + std::to_string(count) +
                    " coefficients of harmonics, expected 0, 9, 24, 45 or 72");
}

// Harmonics of a row: those of files have all of red first. @param one a coefficient of the file
void orderHarmonics(const std::vector<int>& columns, const Row& row,
                    std::vector<float>& harmonics) {
    const std::size_t count = columns.size() / 3;
    for (std::size_t i = 0; i < columns.size(); ++i)
        harmonics[3 * (i % count) + i / count] = cell(row, columns[i]);
}

std::vector<int> harmonicColumns(const PlyElement& element, int degree) {
    std::vector<int> columns;
    for (std::size_t i = 0; i < 3 * coefficientsOf(degree); ++i)
        columns.push_back(element.column("f_rest_" + std::to_string(i)));
    return columns;
}

SplatCollector readPlain(PlyFile& file, const PlyElement& vertex) {
    const auto columns = [&](std::initializer_list<const char*> names) {
        std::vector<int> result;
        for (const char* const name : names)
            result.push_back(vertex.column(name));
        return result;
    };
    const std::vector<int> needed =
        columns({"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
                 "rot_0", "rot_1", "rot_2", "rot_3"});
    if (std::count(needed.begin(), needed.end(), -1) > 0) {
        const PlyElement* const faces = file.find("face");
        if (faces != nullptr && faces->count > 0)
            file.refuse(ErrorCode::Unsupported, "is a mesh, expected Gaussian splats");
        file.refuse(ErrorCode::Unsupported,
                    vertex.column("opacity") < 0
                        ? "is a cloud of points, expected Gaussian splats"
                        : "lacks fields of splats, expected x, f_dc_0, opacity, scale_0, rot_0 and "
                          "those that follow them");
    }
    const int third = vertex.column("scale_2"); // discs have none
    const int degree = degreeOf(file, vertex);
    const std::vector<int> rest = harmonicColumns(vertex, degree);
    std::vector<float> harmonics(rest.size());
    SplatCollector collector(vertex.count, degree);
    const std::uint64_t there = file.rows(vertex, [&](const Row& row) {
        const auto at = [&](std::size_t i) { return cell(row, needed[i]); };
        Splat splat;
        splat.centre = {at(0), at(1), at(2)};
        for (int c = 0; c < 3; ++c)
            splat.colour[c] = static_cast<float>(
                0.5 + kHarmonic0 * static_cast<double>(at(3 + static_cast<std::size_t>(c))));
        splat.opacity = opacityOf(static_cast<double>(at(6)));
        splat.radii = {radiusOf(at(7)), radiusOf(at(8)),
                       third < 0 ? 0 : radiusOf(cell(row, third))};
        splat.rotation = {at(9), at(10), at(11), at(12)};
        orderHarmonics(rest, row, harmonics);
        collector.add(splat, harmonics.data());
    });
    if (there < vertex.count) file.tellCut(vertex, there);
    return collector;
}

// PlayCanvas' compressed form: numbers of 8 to 11 bits between the limits of 256 splats.
struct Chunk {
    std::array<std::array<double, 2>, 9> limits; // x y z, scale x y z, r g b: lowest, highest
};

std::vector<Chunk> readChunks(PlyFile& file, const PlyElement& element) {
    constexpr const char* kNames[] = {"x",       "y", "z", "scale_x", "scale_y",
                                      "scale_z", "r", "g", "b"};
    int columns[9][2];
    for (std::size_t k = 0; k < 9; ++k)
        for (int high = 0; high < 2; ++high) {
            columns[k][high] =
                element.column((high == 0 ? "min_" : "max_") + std::string(kNames[k]));
            if (k < 6 && columns[k][high] < 0)
                file.refuse(ErrorCode::BadFormat, "lacks the limits of its chunks, expected a "
                                                  "compressed .ply file");
        }
    std::vector<Chunk> chunks;
    const std::uint64_t there = file.rows(element, [&](const Row& row) {
        Chunk& chunk = chunks.emplace_back();
        for (std::size_t k = 0; k < 9; ++k)
            for (int high = 0; high < 2; ++high) // old files have no limits of colours
                chunk.limits[k][static_cast<std::size_t>(high)] =
                    columns[k][high] < 0 ? high : row[static_cast<std::size_t>(columns[k][high])];
    });
    if (there < element.count) file.tellCut(element, there);
    return chunks;
}

double bitsOf(std::uint32_t packed, unsigned shift, unsigned count) {
    const std::uint32_t most = (1U << count) - 1;
    return static_cast<double>(packed >> shift & most) / most;
}

// The largest of four is left out of the packed number, which says which one it is.
cv::Vec4f smallestThree(std::uint32_t packed) {
    const auto largest = static_cast<int>(packed >> 30);
    cv::Vec4f q;
    double rest = 1;
    unsigned shift = 20;
    for (int i = 0; i < 4; ++i) {
        if (i == largest) continue;
        const double value = (bitsOf(packed, shift, 10) - 0.5) * std::sqrt(2.0);
        q[i] = static_cast<float>(value);
        rest -= value * value;
        shift -= 10;
    }
    q[largest] = static_cast<float>(std::sqrt(std::max(rest, 0.0)));
    return q;
}

SplatCollector readCompressed(PlyFile& file, const PlyElement& vertex,
                              const std::vector<Chunk>& chunks) {
    const std::array<int, 4> columns = {
        vertex.column("packed_position"), vertex.column("packed_rotation"),
        vertex.column("packed_scale"), vertex.column("packed_color")};
    if (std::count(columns.begin(), columns.end(), -1) > 0)
        file.refuse(ErrorCode::BadFormat, "lacks packed fields, expected a compressed .ply file");
    if (chunks.size() < (vertex.count + 255) / 256)
        file.refuse(ErrorCode::BadFormat, "has " + std::to_string(chunks.size()) +
                                              " chunks, expected one for 256 splats");
    std::vector<Splat> splats;
    splats.reserve(vertex.count);
    const std::uint64_t there = file.rows(vertex, [&](const Row& row) {
        const auto packed = [&](std::size_t k) {
            const double value = row[static_cast<std::size_t>(columns[k])];
            return value >= 0 && value <= UINT32_MAX ? static_cast<std::uint32_t>(value) : 0U;
        };
        const Chunk& chunk = chunks[splats.size() / 256];
        const auto between = [&](std::size_t k, double t) {
            return static_cast<float>(chunk.limits[k][0] * (1 - t) + chunk.limits[k][1] * t);
        };
        Splat& splat = splats.emplace_back();
        const std::uint32_t colour = packed(3);
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            constexpr unsigned kShift[] = {21, 11, 0};
            constexpr unsigned kBits[] = {11, 10, 11};
            splat.centre[i] = between(k, bitsOf(packed(0), kShift[k], kBits[k]));
            splat.radii[i] = radiusOf(between(3 + k, bitsOf(packed(2), kShift[k], kBits[k])));
            splat.colour[i] = between(6 + k, bitsOf(colour, 24 - 8 * static_cast<unsigned>(i), 8));
        }
        splat.rotation = smallestThree(packed(1));
        splat.opacity = static_cast<float>(bitsOf(colour, 0, 8));
    });
    if (there < vertex.count) file.tellCut(vertex, there);
    const PlyElement* const sh = file.find("sh");
    const int degree = sh == nullptr ? 0 : degreeOf(file, *sh);
    SplatCollector collector(vertex.count, degree);
    std::size_t i = 0;
    if (degree > 0) {
        file.requireRows(*sh);
        std::vector<float> harmonics(3 * coefficientsOf(degree));
        const std::vector<int> rest = harmonicColumns(*sh, degree);
        file.rows(*sh, [&](const Row& row) {
            Row values = row; // 0 and 255 are the ends, others the middle of their interval
            for (double& value : values)
                value = 8 * ((value == 0 ? 0 : value == 255 ? 1 : (value + 0.5) / 256) - 0.5);
            orderHarmonics(rest, values, harmonics);
            if (i < splats.size()) collector.add(splats[i++], harmonics.data());
        });
    }
    const std::vector<float> none(3 * coefficientsOf(degree));
    for (; i < splats.size(); ++i)
        collector.add(splats[i], none.data());
    return collector;
}

// The camera in the elements of SHARP. @param values of each element
void takeCamera(const std::map<std::string, Row>& values, SplatScene& scene, Notes* notes) {
    const auto of = [&](const char* name, std::size_t count) -> const Row* {
        const auto found = values.find(name);
        return found != values.end() && found->second.size() >= count ? &found->second : nullptr;
    };
    const Row* const lens = of("intrinsic", 4);
    const Row* const size = of("image_size", 2);
    if (lens == nullptr || size == nullptr) return;
    const bool isMatrix = lens->size() >= 9;
    const Row& m = *lens;
    SplatCamera camera;
    const auto side = [&](std::size_t i) { return (*size)[i] >= 1 && (*size)[i] <= 1e5; };
    if (side(0) && side(1))
        camera.size = {static_cast<int>((*size)[0]), static_cast<int>((*size)[1])};
    camera.intrinsics = {m[0], isMatrix ? m[4] : m[1], m[2] - 0.5,
                         (isMatrix ? m[5] : m[3]) - 0.5}; // counted from the corner of a px
    if (const Row* const pose = of("extrinsic", 12)) {
        cv::Vec3d shift;
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                camera.axes(r, c) = (*pose)[static_cast<std::size_t>(4 * r + c)];
            shift[r] = (*pose)[static_cast<std::size_t>(4 * r + 3)];
        }
        camera.eye = -(camera.axes.t() * shift);
    }
    try {
        requireCamera(camera);
    } catch (const Error& problem) {
        addNote(notes, NoteCode::Doubtful,
                "the camera in the file is not used: " + std::string(problem.what()));
        return;
    }
    scene.camera = camera;
    const Row* const disparity = of("disparity", 2);
    const double sum = disparity == nullptr ? 0 : (*disparity)[0] + (*disparity)[1];
    if (sum > 1e-9 && sum < 1e9) scene.focusDistance = 2 / sum;
}

} // namespace

SplatScene parsePly(std::string_view bytes, const std::string& name, Notes* notes) {
    PlyFile file(bytes, name);
    const PlyElement* const vertex = file.find("vertex");
    if (vertex == nullptr) file.refuse(ErrorCode::BadFormat, "has no vertices, expected splats");
    std::vector<Chunk> chunks;
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
            chunks = readChunks(file, element);
        } else if (element.name != "sh") {
            constexpr std::size_t kMost = 64; // values of a camera
            Row& all = values[element.name];
            const std::uint64_t there = file.rows(element, [&](const Row& row) {
                if (!row.empty() && all.size() < kMost) all.push_back(row.front());
            });
            if (there < element.count && !scene) file.tellCut(element, there);
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
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(scene.splats.size()) + "\n";
    const std::size_t rest = 3 * coefficientsOf(scene.degree);
    std::vector<std::string> names = {"x",  "y",      "z",      "nx",    "ny",
                                      "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
    for (std::size_t i = 0; i < rest; ++i)
        names.push_back("f_rest_" + std::to_string(i));
    for (const char* const name :
         {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        names.emplace_back(name);
    for (const std::string& name : names)
        text += "property float " + name + "\n";
    std::string tail;
    const auto put = [](std::string& to, auto value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        to.append(raw, sizeof value);
    };
    if (scene.camera) { // the elements of SHARP, of one property each, of their own name
        const SplatCamera& camera = *scene.camera;
        const CameraIntrinsics& lens = camera.intrinsics;
        const auto floats = [&](const char* name, const std::vector<double>& values) {
            text += "element " + std::string(name) + " " + std::to_string(values.size()) +
                    "\nproperty float " + name + "\n";
            for (const double value : values)
                put(tail, static_cast<float>(value));
        };
        const cv::Vec3d shift = -(camera.axes * camera.eye);
        std::vector<double> pose;
        for (int r = 0; r < 3; ++r)
            pose.insert(pose.end(),
                        {camera.axes(r, 0), camera.axes(r, 1), camera.axes(r, 2), shift[r]});
        pose.insert(pose.end(), {0, 0, 0, 1});
        floats("extrinsic", pose);
        floats("intrinsic", {lens.fx, 0, lens.cx + 0.5, 0, lens.fy, lens.cy + 0.5, 0, 0, 1});
        text += "element image_size 2\nproperty uint image_size\n";
        put(tail, static_cast<std::uint32_t>(camera.size.width));
        put(tail, static_cast<std::uint32_t>(camera.size.height));
        if (scene.focusDistance > 0)
            floats("disparity", {1 / scene.focusDistance, 1 / scene.focusDistance});
    }
    text += "end_header\n";
    text.reserve(text.size() + scene.splats.size() * 4 * names.size() + tail.size());
    for (std::size_t i = 0; i < scene.splats.size(); ++i) {
        const Splat& splat = scene.splats[i];
        const auto vector = [&](const auto& values) {
            for (const float value : values.val)
                put(text, value);
        };
        vector(splat.centre);
        vector(cv::Vec3f());
        for (const float value : splat.colour.val)
            put(text, static_cast<float>((static_cast<double>(value) - 0.5) / kHarmonic0));
        for (std::size_t k = 0; k < rest; ++k) // all of red first
            put(text, scene.harmonics[i * rest + 3 * (k % (rest / 3)) + k / (rest / 3)]);
        const double opacity = static_cast<double>(splat.opacity);
        put(text, static_cast<float>(std::log(opacity / (1 - opacity))));
        for (const float radius : splat.radii.val)
            put(text, static_cast<float>(std::log(static_cast<double>(radius))));
        vector(splat.rotation);
    }
    return text + tail;
}

} // namespace altiro3D
