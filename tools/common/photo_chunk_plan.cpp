#include "common/photo_chunk_plan.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"

#include <QByteArray>
#include <QCryptographicHash>
#include <algorithm>
#include <set>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kPlanFormat = "altiro3D photo plan";
constexpr const char* kChunkFormat = "altiro3D photo chunk";
constexpr int kVersion = 1;
constexpr const char* kPlanFile = "plan.json";
constexpr const char* kChunks = "chunks";
constexpr const char* kLogs = "logs";
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{256} << 20;

// File names need not be UTF-8, but JSON is.
std::string encoded(const fs::path& path) {
    return QByteArray::fromStdString(path.string())
        .toPercentEncoding(" !#$&'()+,/:;=@[]{}")
        .toStdString();
}

fs::path decoded(const std::string& text) {
    return QByteArray::fromPercentEncoding(QByteArray::fromStdString(text)).toStdString();
}

std::string textOf(const Json& value) {
    return value.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// The file of a plan or a record.
struct PlanText {
    std::string text;
    Json json;
};

[[noreturn]] void failDamaged(const fs::path& file) {
    throw Error(ErrorCode::BadFormat, file.string(),
                "is damaged, expected the file as it was written");
}

PlanText readText(const fs::path& file) {
    PlanText read{readFile(file, kMaxFileBytes), {}};
    read.json = Json::parse(read.text, nullptr, false);
    if (!read.json.is_object()) failDamaged(file);
    return read;
}

// Reads values; everything that the file should have and has not is damage.
template <typename Reading>
void readValues(const fs::path& file, const Reading& reading) {
    try {
        reading();
    } catch (const Json::exception&) {
        failDamaged(file);
    }
}

FileKind kindOf(const Json& value, const fs::path& file) {
    const auto number = value.get<std::int64_t>();
    if (number < 0 || number > static_cast<int>(FileKind::Other)) failDamaged(file);
    return static_cast<FileKind>(number);
}

double numberOf(const Json& value, const fs::path& file) {
    const double number = value.get<double>();
    if (!(number >= 0 && number <= 1e15)) failDamaged(file);
    return number;
}

fs::path recordFile(const fs::path& folder, int number) {
    std::string digits = std::to_string(number);
    digits.insert(0, digits.size() < 6 ? 6 - digits.size() : 0, '0');
    return folder / kChunks / (digits + ".json");
}

Json jsonOf(const PhotoResult& photo) {
    Json outputs = Json::array();
    for (const auto& [file, bytes] : photo.outputs)
        outputs.push_back({{"file", encoded(file)}, {"bytes", bytes}});
    return {{"end", static_cast<int>(photo.end)},
            {"text", photo.text},
            {"kind", static_cast<int>(photo.kind)},
            {"ofMachine", photo.isOfMachine},
            {"warnings", photo.warnings},
            {"outputs", outputs},
            {"report", photo.report}};
}

PhotoResult photoOf(const Json& entry, const fs::path& file) {
    PhotoResult photo;
    const auto end = entry.at("end").get<std::int64_t>();
    if (end < 0 || end > static_cast<int>(PhotoResult::End::Failed)) failDamaged(file);
    photo.end = static_cast<PhotoResult::End>(end);
    photo.text = entry.at("text").get<std::string>();
    photo.kind = kindOf(entry.at("kind"), file);
    photo.isOfMachine = entry.at("ofMachine").get<bool>();
    photo.warnings = entry.at("warnings").get<std::vector<std::string>>();
    for (const Json& output : entry.at("outputs")) {
        photo.outputs.emplace_back(decoded(output.at("file").get<std::string>()),
                                   output.at("bytes").get<std::uintmax_t>());
    }
    photo.report = entry.at("report");
    return photo;
}

} // namespace

int PhotoChunkPlan::chunks() const {
    const auto most = static_cast<std::size_t>(chunkPhotos);
    return static_cast<int>((inputs.files.size() + most - 1) / most);
}

std::pair<std::size_t, std::size_t> PhotoChunkPlan::photosOf(int number) const {
    if (number < 1 || number > chunks()) {
        throw Error(ErrorCode::InvalidArgument, "chunk",
                    "is " + std::to_string(number) + ", expected 1.." + std::to_string(chunks()));
    }
    const auto most = static_cast<std::size_t>(chunkPhotos);
    const std::size_t first = static_cast<std::size_t>(number - 1) * most;
    return {first, std::min(first + most, inputs.files.size())};
}

bool holdsPlan(const fs::path& folder) {
    std::error_code error;
    return fs::exists(folder / kPlanFile, error);
}

bool isPhotoPlan(const fs::path& folder) {
    if (!holdsPlan(folder)) return false;
    try {
        const Json json = readText(folder / kPlanFile).json;
        return json.contains("format") && json["format"] == kPlanFormat;
    } catch (const Error&) {
        return false;
    }
}

PhotoChunkPlan readPhotoChunks(const fs::path& folder) {
    const fs::path file = folder / kPlanFile;
    if (!holdsPlan(folder)) {
        throw Error(ErrorCode::NotFound, folder.string(),
                    "holds no plan, expected the folder of a plan");
    }
    const PlanText read = readText(file);
    const Json& json = read.json;
    PhotoChunkPlan plan;
    readValues(file, [&] {
        if (json.at("format") != kPlanFormat || json.at("version") != kVersion) {
            throw Error(ErrorCode::BadFormat, file.string(),
                        "is not a plan of photos of this version, expected one that this program "
                        "has made");
        }
        const auto threads = json.at("threads").get<std::int64_t>();
        const auto photos = json.at("chunkPhotos").get<std::int64_t>();
        if (threads < 1 || threads > 1 << 20 || photos < 1 || photos > 1000000) failDamaged(file);
        plan.threads = static_cast<int>(threads);
        plan.chunkPhotos = static_cast<int>(photos);
        plan.stamp = json.at("stamp").get<PhotoRunStamp>();
        plan.report = json.at("report");
        if (!plan.report.is_object()) failDamaged(file);
        plan.warnings = json.at("warnings").get<std::vector<std::string>>();
        for (const Json& photo : json.at("photos")) {
            plan.inputs.files.push_back({decoded(photo.at("photo").get<std::string>()),
                                         decoded(photo.at("depth").get<std::string>()),
                                         decoded(photo.at("folder").get<std::string>())});
            plan.stamps.push_back(photo.at("stamp").get<std::string>());
        }
        for (const Json& other : json.at("leftOut")) {
            plan.inputs.leftOut.push_back({decoded(other.at("file").get<std::string>()),
                                           kindOf(other.at("kind"), file),
                                           other.at("why").get<std::string>()});
        }
        if (plan.inputs.files.empty()) failDamaged(file);
    });
    plan.inputs.batch = true;
    plan.id =
        QCryptographicHash::hash(QByteArray::fromStdString(read.text), QCryptographicHash::Sha1)
            .toHex()
            .toStdString();
    return plan;
}

void makePhotoPlanFolder(const fs::path& folder) {
    static const std::set<std::string> kOurs = {kPlanFile, "arguments", "visual.json", kChunks,
                                                kLogs};
    std::error_code error;
    if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
        throw Error(ErrorCode::WriteFailed, folder.string(), "is a file, expected a new folder");
    }
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (kOurs.count(name) == 0 && name.rfind(".altiro3D-", 0) != 0) {
            throw Error(ErrorCode::WriteFailed, folder.string(),
                        "holds other files (" + name + "), expected a new folder");
        }
    }
    for (const char* name : {kChunks, kLogs}) {
        fs::create_directories(folder / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (folder / name).string(),
                        "cannot be made: " + error.message() + ", expected a folder to write to");
        }
    }
}

void removePhotoChunks(const fs::path& folder) {
    std::error_code error;
    for (const char* name : {kPlanFile, kChunks, kLogs}) {
        fs::remove_all(folder / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (folder / name).string(),
                        "cannot be removed: " + error.message());
        }
    }
}

void writePhotoChunks(const PhotoChunkPlan& plan, const fs::path& folder) {
    Json photos = Json::array();
    for (std::size_t i = 0; i < plan.inputs.files.size(); ++i) {
        const FolderFile& file = plan.inputs.files[i];
        photos.push_back({{"photo", encoded(file.file)},
                          {"depth", encoded(file.depth)},
                          {"folder", encoded(file.folder)},
                          {"stamp", plan.stamps[i]}});
    }
    Json leftOut = Json::array();
    for (const LeftOutFile& other : plan.inputs.leftOut) {
        leftOut.push_back({{"file", encoded(other.file)},
                           {"kind", static_cast<int>(other.kind)},
                           {"why", other.why}});
    }
    writeFile(folder / kPlanFile, textOf({{"format", kPlanFormat},
                                          {"version", kVersion},
                                          {"threads", plan.threads},
                                          {"chunkPhotos", plan.chunkPhotos},
                                          {"stamp", plan.stamp},
                                          {"photos", photos},
                                          {"leftOut", leftOut},
                                          {"warnings", plan.warnings},
                                          {"report", plan.report}}));
}

std::optional<PhotoChunkRecord> readPhotoChunk(const PhotoChunkPlan& plan, const fs::path& folder,
                                               int number) {
    const auto [first, end] = plan.photosOf(number);
    const fs::path file = recordFile(folder, number);
    std::error_code error;
    if (!fs::exists(file, error)) return std::nullopt;
    const Json json = readText(file).json;
    PhotoChunkRecord record;
    bool isOfPlan = true;
    readValues(file, [&, first = first, end = end] {
        if (json.at("format") != kChunkFormat || json.at("version") != kVersion) failDamaged(file);
        isOfPlan = json.at("plan") == plan.id;
        record.host = json.at("host").get<std::string>();
        record.seconds = numberOf(json.at("seconds"), file);
        record.peakMegabytes = numberOf(json.at("peakMegabytes"), file);
        record.depth = json.at("depth");
        if (!record.depth.contains("depth") || !record.depth.contains("network")) failDamaged(file);
        for (const Json& entry : json.at("photos"))
            record.photos.push_back(photoOf(entry, file));
        if (isOfPlan && record.photos.size() != end - first) failDamaged(file);
    });
    if (!isOfPlan) return std::nullopt;
    return record;
}

void writePhotoChunk(const PhotoChunkPlan& plan, const fs::path& folder, int number,
                     const PhotoChunkRecord& record) {
    Json photos = Json::array();
    for (const PhotoResult& photo : record.photos)
        photos.push_back(jsonOf(photo));
    writeFile(recordFile(folder, number), textOf({{"format", kChunkFormat},
                                                  {"version", kVersion},
                                                  {"plan", plan.id},
                                                  {"host", record.host},
                                                  {"seconds", record.seconds},
                                                  {"peakMegabytes", record.peakMegabytes},
                                                  {"depth", record.depth},
                                                  {"photos", photos}}));
}

void requireOutputs(const PhotoChunkRecord& record, int number) {
    for (const PhotoResult& photo : record.photos) {
        for (const auto& [file, bytes] : photo.outputs) {
            std::error_code error;
            const std::uintmax_t there = fs::file_size(file, error);
            if (!error && there == bytes) continue;
            throw Error(ErrorCode::BadFormat, file.string(),
                        std::string(error ? "is missing" : "has another size") +
                            ", expected the file as chunk " + std::to_string(number) +
                            " wrote it; make this chunk again");
        }
    }
}

bool isPhotoChunkMade(const PhotoChunkPlan& plan, const fs::path& folder, int number) {
    static_cast<void>(plan.photosOf(number)); // throws
    try {
        const std::optional<PhotoChunkRecord> record = readPhotoChunk(plan, folder, number);
        if (!record) return false;
        requireOutputs(*record, number);
        return std::none_of(record->photos.begin(), record->photos.end(),
                            [](const PhotoResult& photo) { return photo.isOfMachine; });
    } catch (const Error&) {
        return false;
    }
}

std::string fileStamp(const fs::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) return "missing";
    const auto time = fs::last_write_time(file, error).time_since_epoch().count();
    if (error) return "missing";
    return std::to_string(bytes) + " bytes of " + std::to_string(time);
}

std::string photoStamp(const FolderFile& file) {
    return fileStamp(file.file) +
           (file.depth.empty() ? "" : ", with depth of " + fileStamp(file.depth));
}

} // namespace altiro3D::tools
