#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/json_reader.hpp"
#include "base/system_file.hpp"
#include "base/system_process.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <type_traits>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxJsonBytes = 1024 * 1024;
constexpr JsonLimits kLimits{16, 1000, true}; // a catalogue needs 4 levels
constexpr std::size_t kMaxNetworks = 1000;
constexpr int kMaxSide = 4096;

std::string inQuotes(const std::string& text) {
    return '"' + shortened(text) + '"';
}

bool isPlainName(const std::string& text) {
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '.' || c == '_' || c == '-';
    };
    return !text.empty() && text.size() <= 64 && text[0] != '.' && text[0] != '-' &&
           std::all_of(text.begin(), text.end(), allowed);
}

bool isLowerHex(const std::string& text) {
    return std::all_of(text.begin(), text.end(),
                       [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// Calls complain(good, field, "is ..., expected ...") for each field.
template <class Complain>
void checkFields(const NetworkProfile& profile, const Complain& complain) {
    complain(isPlainName(profile.name), "name",
             "is " + inQuotes(profile.name) + ", expected 1..64 letters, digits, '.', '_' or '-'");
    complain(profile.file.empty() || isPlainName(profile.file), "file",
             "is " + inQuotes(profile.file) +
                 ", expected a file name without directories, of letters, digits, '.', '_' or '-'");
    complain(profile.url.empty() || profile.url.rfind("https://", 0) == 0, "url",
             "is " + inQuotes(profile.url) + ", expected https://...");
    complain(profile.sha256.empty() || (profile.sha256.size() == 64 && isLowerHex(profile.sha256)),
             "sha256",
             "is " + inQuotes(profile.sha256) + ", expected 64 lower-case hexadecimal digits");
    const auto checkSide = [&](const char* field, int value) {
        complain(value >= 1 && value <= kMaxSide, field,
                 "is " + std::to_string(value) + ", expected a whole number 1..4096");
    };
    checkSide("multipleOf", profile.multipleOf);
    for (const auto& [field, value] :
         {std::pair<const char*, int>{"inputWidth", profile.inputWidth},
          {"inputHeight", profile.inputHeight}}) {
        checkSide(field, value);
        complain(value % profile.multipleOf == 0, field,
                 "is " + std::to_string(value) + ", expected a multiple of " +
                     std::to_string(profile.multipleOf));
    }
    const auto checkFactor = [&](const std::string& field, double value) {
        complain(std::isfinite(value) && value != 0, field,
                 "is " + numberText(value) + ", expected a number other than 0");
    };
    checkFactor("scale", profile.scale);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::string index = '[' + std::to_string(i) + ']';
        complain(std::isfinite(profile.mean[i]), "mean" + index,
                 "is " + numberText(profile.mean[i]) + ", expected a number");
        checkFactor("std" + index, profile.std[i]);
    }
}

bool isSide(const Json& value) {
    if (!value.is_number_integer()) return false;
    const bool isLarge = value.is_number_unsigned() && value.get<std::uint64_t>() > kMaxSide;
    return !isLarge && value.get<std::int64_t>() >= 1;
}

// Reads the fields of one JSON object. Errors name the file and the field.
class FieldReader {
  public:
    FieldReader(std::string file, std::string prefix, const Json& object)
        : file_(std::move(file)), prefix_(std::move(prefix)), object_(object) {}

    [[noreturn]] void fail(const std::string& field, const std::string& problem) const {
        throw Error(ErrorCode::BadFormat, file_ + ": " + prefix_ + field, problem);
    }

    [[noreturn]] void failExpecting(const std::string& field, const Json& value,
                                    const std::string& expected) const {
        fail(field, "is " + shownJson(value) + ", expected " + expected);
    }

    // The field's value; null if it is absent and not required.
    const Json* find(const std::string& field, bool required) const {
        const auto found = object_.find(field);
        if (found != object_.end()) return &*found;
        if (required) fail(field, "is missing, expected it in every network");
        return nullptr;
    }

    template <typename T>
    void read(const std::string& field, T& target, bool required = false) const {
        const Json* const value = find(field, required);
        if (value == nullptr) return;
        const auto expect = [&](bool isRight, const char* expected) {
            if (!isRight) failExpecting(field, *value, expected);
        };
        if constexpr (std::is_same_v<T, std::string>) expect(value->is_string(), "a text");
        if constexpr (std::is_same_v<T, bool>) expect(value->is_boolean(), "true or false");
        if constexpr (std::is_same_v<T, double>) expect(value->is_number(), "a number");
        if constexpr (std::is_same_v<T, std::uint64_t>)
            expect(value->is_number_unsigned(), "a whole number of bytes, 0 if unknown");
        if constexpr (std::is_same_v<T, int>) expect(isSide(*value), "a whole number 1..4096");
        target = value->get<T>();
    }

    void read(const std::string& field, std::array<double, 3>& target) const {
        const Json* value = find(field, false);
        if (value == nullptr) return;
        const std::string expected = "a list of three numbers";
        if (!value->is_array()) failExpecting(field, *value, expected);
        if (value->size() != 3) {
            fail(field, "has " + std::to_string(value->size()) + " entries, expected " + expected);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const Json& entry = (*value)[i];
            if (!entry.is_number()) {
                failExpecting(field + '[' + std::to_string(i) + ']', entry, "a number");
            }
            target[i] = entry.get<double>();
        }
    }

    // Reads one of a few words.
    template <typename Value>
    void read(const std::string& field, const std::vector<std::pair<std::string, Value>>& words,
              Value& target) const {
        const Json* value = find(field, false);
        if (value == nullptr) return;
        std::string expected;
        for (const auto& word : words) {
            if (value->is_string() && value->get_ref<const std::string&>() == word.first) {
                target = word.second;
                return;
            }
            if (!expected.empty()) expected += &word == &words.back() ? " or " : ", ";
            expected += inQuotes(word.first);
        }
        failExpecting(field, *value, expected);
    }

  private:
    std::string file_;
    std::string prefix_;
    const Json& object_;
};

NetworkProfile readProfile(const std::string& file, const std::string& prefix, const Json& object) {
    const FieldReader reader(file, prefix, object);
    NetworkProfile profile;
    reader.read("name", profile.name, true);
    reader.read("file", profile.file);
    reader.read("url", profile.url);
    reader.read("bytes", profile.bytes);
    reader.read("sha256", profile.sha256);
    reader.read("licence", profile.licence);
    reader.read("large", profile.large);
    reader.read("inputWidth", profile.inputWidth, true);
    reader.read("inputHeight", profile.inputHeight, true);
    reader.read("multipleOf", profile.multipleOf);
    reader.read<ChannelOrder>("channelOrder",
                              {{"RGB", ChannelOrder::Rgb}, {"BGR", ChannelOrder::Bgr}},
                              profile.channelOrder);
    reader.read<InputShape>("inputShape",
                            {{"fixed", InputShape::Fixed}, {"photo", InputShape::Photo}},
                            profile.inputShape);
    reader.read("scale", profile.scale);
    reader.read("mean", profile.mean);
    reader.read("std", profile.std);
    reader.read<ResizeKernel>("resizeKernel",
                              {{"nearest", ResizeKernel::Nearest},
                               {"linear", ResizeKernel::Linear},
                               {"cubic", ResizeKernel::Cubic},
                               {"area", ResizeKernel::Area}},
                              profile.resizeKernel);
    reader.read<NetworkOutput>("output",
                               {{"inverseDepth", NetworkOutput::InverseDepth},
                                {"metricDepth", NetworkOutput::MetricDepth}},
                               profile.output);
    reader.read<InferenceEngine>("engine",
                                 {{"best", InferenceEngine::Best},
                                  {"opencv", InferenceEngine::OpenCv},
                                  {"onnxruntime", InferenceEngine::OnnxRuntime}},
                                 profile.engine);
    checkFields(profile, [&](bool good, const std::string& field, const std::string& problem) {
        if (!good) reader.fail(field, problem);
    });
    return profile;
}

Json readJsonObject(const fs::path& path, const std::string& expected) {
    const std::string file = path.string();
    const std::string text = readFile(path, kMaxJsonBytes);
    Json document = parseJson(text, file, expected, kLimits);
    if (!document.is_object()) {
        throw Error(ErrorCode::BadFormat, file,
                    "is " + shownJson(document) + ", expected " + expected);
    }
    return document;
}

} // namespace

bool canRun(const NetworkProfile& profile) {
    return profile.engine != InferenceEngine::OnnxRuntime || hasOnnxRuntime();
}

void validate(const NetworkProfile& profile) {
    checkFields(profile, [](bool good, const std::string& field, const std::string& problem) {
        if (!good) throw Error(ErrorCode::InvalidArgument, field, problem);
    });
}

NetworkProfile readNetworkProfile(const fs::path& file) {
    const Json document = readJsonObject(file, "an object with the fields of one network");
    return readProfile(file.string(), "", document);
}

std::vector<NetworkProfile> readModelCatalog(const fs::path& file) {
    const std::string expected = R"({"networks": [...]})";
    const Json document = readJsonObject(file, expected);
    const auto fail = [&](const std::string& place, const std::string& problem) {
        throw Error(ErrorCode::BadFormat, file.string() + place, problem);
    };
    const auto networks = document.find("networks");
    if (networks == document.end()) fail("", "has no \"networks\", expected " + expected);
    if (!networks->is_array())
        fail(": networks", "is " + shownJson(*networks) + ", expected a list");
    if (networks->size() > kMaxNetworks) {
        fail(": networks", "has " + std::to_string(networks->size()) +
                               " entries, expected at most " + std::to_string(kMaxNetworks));
    }
    std::vector<NetworkProfile> catalog;
    std::set<std::string> names;
    std::set<std::string> files;
    for (const Json& entry : *networks) {
        const std::string place = "networks[" + std::to_string(catalog.size()) + ']';
        if (!entry.is_object())
            fail(": " + place, "is " + shownJson(entry) + ", expected an object");
        NetworkProfile profile = readProfile(file.string(), place + '.', entry);
        const auto refuse = [&](const std::string& field, const std::string& problem) {
            fail(": " + place + '.' + field, problem);
        };
        if (profile.file.empty()) refuse("file", "is empty, expected the ONNX file's name");
        const auto checkNew = [&](std::set<std::string>& known, const std::string& field,
                                  const std::string& value) {
            if (known.insert(value).second) return;
            refuse(field,
                   "is " + inQuotes(value) + " for the second time, expected a new " + field);
        };
        checkNew(names, "name", profile.name);
        checkNew(files, "file", profile.file);
        catalog.push_back(std::move(profile));
    }
    return catalog;
}

const NetworkProfile* findProfile(const std::vector<NetworkProfile>& catalog,
                                  const fs::path& modelFile) {
    const std::string name = modelFile.filename().string();
    const auto found =
        std::find_if(catalog.begin(), catalog.end(), [&](const NetworkProfile& profile) {
            return !name.empty() && profile.file == name;
        });
    return found == catalog.end() ? nullptr : &*found;
}

std::vector<fs::path> modelSearchPath() {
    std::vector<fs::path> candidates;
    std::istringstream list(environmentOf("ALTIRO3D_MODELS"));
    for (std::string entry; std::getline(list, entry, kListSeparator);) {
        if (!entry.empty()) candidates.emplace_back(entry);
    }
    if (const fs::path data = userDataDirectory(); !data.empty())
        candidates.push_back(data / "altiro3D" / "models");
    for (const fs::path& directory : dataDirectories())
        candidates.push_back(directory / "models");

    std::vector<fs::path> directories;
    for (const fs::path& candidate : candidates) {
        std::error_code error; // an unreadable directory counts as missing
        if (!fs::is_directory(candidate, error)) continue;
        const bool known =
            std::any_of(directories.begin(), directories.end(), [&](const fs::path& earlier) {
                return stateOf(earlier).id == stateOf(candidate).id;
            });
        if (!known) directories.push_back(candidate);
    }
    return directories;
}

fs::path findModelFile(const std::string& name, const std::vector<fs::path>& searchPath) {
    if (name.empty() || fs::path(name).is_absolute()) return {};
    for (const fs::path& directory : searchPath) {
        fs::path file = directory / name;
        std::error_code error;
        if (fs::exists(file, error) && !fs::is_directory(file, error)) return file;
    }
    return {};
}

std::vector<NetworkProfile> modelCatalog(const std::vector<fs::path>& searchPath) {
    const fs::path file = findModelFile("catalog.json", searchPath);
    return file.empty() ? std::vector<NetworkProfile>() : readModelCatalog(file);
}

std::vector<InstalledNetwork> installedNetworks(const std::vector<fs::path>& searchPath) {
    std::vector<InstalledNetwork> installed;
    for (NetworkProfile& profile : modelCatalog(searchPath)) {
        fs::path file = findModelFile(profile.file, searchPath);
        if (!file.empty()) installed.push_back({std::move(profile), std::move(file)});
    }
    return installed;
}

std::optional<InstalledNetwork> standardNetwork(bool large,
                                                const std::vector<fs::path>& searchPath) {
    for (InstalledNetwork& network : installedNetworks(searchPath)) {
        if (network.profile.large == large && canRun(network.profile)) return std::move(network);
    }
    return std::nullopt;
}

} // namespace altiro3D
