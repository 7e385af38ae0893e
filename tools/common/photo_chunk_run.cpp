#include "common/photo_chunk_run.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/chunk_folder.hpp"
#include "common/folder_run.hpp"
#include "common/photo_chunk_plan.hpp"
#include "common/photo_run.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kLength = "chunk-photos";
constexpr int kChunkPhotos = 100; // of 0.2 to 1 s each
constexpr int kMaxChunkPhotos = 1000000;

// What the outputs depend on, besides the photos.
PhotoRunStamp stampOf(const CommandLine& commandLine, const PhotoRun& run) {
    static const std::set<std::string> kOthers = {
        "plan", kLength, "y", "v", "j", "c"}; // the calibration has its fingerprint
    PhotoRunStamp stamp;
    for (const auto& [option, value] : commandLine.given()) {
        if (kOthers.count(option) == 0)
            stamp[(option.size() > 1 ? "--" : "-") + option] = oneLine(value);
    }
    std::string names;
    for (const fs::path& name : commandLine.files())
        names += (names.empty() ? "" : ", ") + name.string();
    stamp["names"] = oneLine(names);
    stamp["folder"] = oneLine(fs::current_path().string());
    stamp["display"] = fingerprintText(run.display.map ? run.display.map->calibrationFingerprint()
                                                       : fingerprint(run.display.calibration));
    for (const char* option : {"m", "camera", "net-profile"}) {
        if (const auto file = commandLine.value(option))
            stamp["file of " + std::string(option[1] == '\0' ? "-" : "--") + option] =
                fileStamp(*file);
    }
    stamp["depth"] = run.depth.description();
    if (!run.depth.networkFile().empty()) stamp["network"] = fileStamp(run.depth.networkFile());
    stamp["threads"] = std::to_string(cv::getNumThreads());
    stamp["version"] = version();
    stamp["version of OpenCV"] = CV_VERSION;
    for (auto& [name, value] : stamp) // as a file of JSON holds it
        value = Json::parse(Json(value).dump(-1, ' ', false, Json::error_handler_t::replace))
                    .get<std::string>();
    return stamp;
}

// The first difference as a sentence; empty: none.
std::string differenceOf(const PhotoRunStamp& before, const PhotoRunStamp& now) {
    const auto valueOf = [](const PhotoRunStamp& stamp, const std::string& name) {
        const auto found = stamp.find(name);
        return found == stamp.end()    ? std::string("not set")
               : found->second.empty() ? std::string("set")
                                       : found->second;
    };
    for (const PhotoRunStamp* stamp : {&before, &now}) {
        for (const auto& [name, value] : *stamp) {
            const std::string was = valueOf(before, name);
            const std::string is = valueOf(now, name);
            if (was != is) return name + " was " + was + " and is " + is;
        }
    }
    return {};
}

// Requires photos from..end of a plan as they were.
void requirePhotos(const PhotoChunkPlan& plan, std::size_t from, std::size_t end) {
    for (std::size_t i = from; i < end; ++i) {
        const FolderFile& file = plan.inputs.files[i];
        const std::string now = photoStamp(file);
        if (now == plan.stamps[i]) continue;
        throw Error(ErrorCode::Mismatch, file.file.string(),
                    "was " + plan.stamps[i] + " when the plan was made and is " + now +
                        ", expected the same file");
    }
}

// The plan of the same run, if the folder holds it. @throws Error Mismatch (another plan)
std::optional<PhotoChunkPlan> samePlan(const PhotoChunkPlan& wanted, const fs::path& folder) {
    if (!holdsPlan(folder)) return std::nullopt;
    PhotoChunkPlan there = readPhotoChunks(folder);
    std::string other = differenceOf(there.stamp, wanted.stamp);
    if (other.empty() && there.chunkPhotos != wanted.chunkPhotos) {
        other = std::string("--") + kLength + " was " + std::to_string(there.chunkPhotos) +
                " and is " + std::to_string(wanted.chunkPhotos);
    }
    const std::vector<FolderFile>& before = there.inputs.files;
    const std::vector<FolderFile>& now = wanted.inputs.files;
    for (std::size_t i = 0; other.empty() && i < std::max(before.size(), now.size()); ++i) {
        const bool isInBoth = i < before.size() && i < now.size();
        if (isInBoth && before[i].file == now[i].file && there.stamps[i] == wanted.stamps[i])
            continue;
        other = "photo " + std::to_string(i + 1) + " was " +
                (i < before.size() ? before[i].file.string() + ", " + there.stamps[i] : "none") +
                " and is " +
                (i < now.size() ? now[i].file.string() + ", " + wanted.stamps[i] : "none");
    }
    if (other.empty()) return there;
    throw Error(ErrorCode::Mismatch, folder.string(),
                "holds a plan of another run (" + other +
                    "), expected a new folder, or -y to replace it");
}

int plan(const CommandLine& commandLine, const std::vector<std::string>& arguments,
         const fs::path& folder, Messages& messages) {
    StageTimes setup;
    setup.add("start", 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
    for (const char* option : {"budget", "skip-existing"})
        commandLine.exclude("plan", option);
    PhotoChunkPlan wanted;
    wanted.chunkPhotos =
        commandLine.wholeNumber(kLength, 1, kMaxChunkPhotos).value_or(kChunkPhotos);
    const PhotoSettings settings = photoSettings(commandLine, messages);
    wanted.inputs = listPhotos(commandLine, messages);
    if (!wanted.inputs.batch) {
        throw UsageError("--plan applies to several photos, expected a folder or several photos, "
                         "and a folder for the outputs");
    }
    PhotoPlan photos = planPhotos(commandLine, settings.display, settings.layout, wanted.inputs);
    messages.say("quilt: " + quiltText(settings.layout, settings.display.aspect()));
    setup.end("plan");
    const PhotoRun run = openPhotoRun(commandLine, settings, setup, messages);
    wanted.threads = cv::getNumThreads();
    wanted.stamp = stampOf(commandLine, run);
    for (const FolderFile& file : wanted.inputs.files)
        wanted.stamps.push_back(photoStamp(file));
    if (commandLine.has("y") && holdsPlan(folder)) {
        static_cast<void>(readPhotoChunks(folder)); // refuses the plans of other tools
        removePhotoChunks(folder);
    }
    const std::optional<PhotoChunkPlan> there = samePlan(wanted, folder);
    if (!there) {
        static_cast<void>(
            checkedOutputs(commandLine, photos, settings.display, settings.layout.viewCount));
    }
    makePhotoPlanFolder(folder);
    keepCommandLine(folder, arguments, commandLine, settings.display);
    if (!there) {
        wanted.report = photoReport(commandLine, run, messages);
        for (const auto& [stage, milliseconds] : setup.milliseconds())
            wanted.report["setupMilliseconds"][stage] = milliseconds;
        wanted.warnings = messages.warnings();
        writePhotoChunks(wanted, folder);
    }
    messages.say(folder.string() + ": " + counted(wanted.chunks(), "chunk") + ", " +
                 counted(wanted.inputs.files.size(), "photo"));
    return kExitDone;
}

// A run as its plan states it.
struct PlannedPhotos { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    PhotoChunkPlan plan;
    std::unique_ptr<CommandLine> commandLine;
    std::optional<PhotoSettings> settings;
    std::optional<PhotoRun> run;
    PhotoPlan photos;
};

// Opens the run of a plan as the plan's command line did, in its working directory.
void openPlanned(const ChunkCall& call, const std::string& tool,
                 const std::function<void(CommandLine&)>& addOptions, PlannedPhotos& planned,
                 Messages& messages) {
    planned.plan = readPhotoChunks(call.folder);
    planned.commandLine = openCommandLine(
        call.folder, tool, planned.plan.threads, addOptions, [&](const CommandLine& commandLine) {
            StageTimes times;
            planned.settings.emplace(photoSettings(commandLine, messages));
            planned.run.emplace(openPhotoRun(commandLine, *planned.settings, times, messages));
            const std::string other =
                differenceOf(planned.plan.stamp, stampOf(commandLine, *planned.run));
            if (!other.empty()) {
                throw Error(ErrorCode::Mismatch, call.folder.string(),
                            "was planned with other settings (" + other + "), expected the same");
            }
            planned.photos = planPhotos(commandLine, planned.settings->display,
                                        planned.settings->layout, planned.plan.inputs);
        });
}

// Whether a photo may be made by another machine, or later.
bool isFailureOfMachine(const std::exception& error) {
    if (const auto* ours = dynamic_cast<const Error*>(&error)) {
        return ours->code() == ErrorCode::WriteFailed || ours->code() == ErrorCode::OutOfMemory ||
               ours->code() == ErrorCode::NetworkFailed;
    }
    if (const auto* fromOpenCv = dynamic_cast<const cv::Exception*>(&error))
        return fromOpenCv->code == cv::Error::StsNoMem;
    return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
           dynamic_cast<const std::system_error*>(&error) != nullptr;
}

// Makes one photo of a chunk.
PhotoResult makePhoto(const PhotoItem& item, PlannedPhotos& planned, FolderRun& folder,
                      Messages& messages) {
    PhotoResult result;
    const std::size_t before = messages.warnings().size();
    const FolderRun::Outcome outcome = folder.convert(item.photo, [&] {
        try {
            result.report = makePicture(*planned.commandLine, item, *planned.run, messages);
        } catch (const NotTaken& other) {
            result.kind = other.file.kind;
            throw;
        } catch (const std::exception& error) {
            result.isOfMachine = isFailureOfMachine(error);
            throw;
        }
        return kExitDone;
    });
    result.warnings.assign(messages.warnings().begin() + static_cast<std::ptrdiff_t>(before),
                           messages.warnings().end());
    if (!outcome.leftOut.empty()) {
        result.end = PhotoResult::End::LeftOut;
        result.text = outcome.leftOut;
        result.report = {{"photo", item.photo.string()}, {"leftOut", outcome.leftOut}};
    } else if (!outcome.error.empty()) {
        result.end = PhotoResult::End::Failed;
        result.text = outcome.error;
        result.report = {{"photo", item.photo.string()}, {"error", outcome.error}};
    } else {
        for (const fs::path& file : outputsOf(item, planned.settings->layout.viewCount))
            result.outputs.emplace_back(fs::absolute(file), fs::file_size(file));
    }
    return result;
}

int makeChunk(const ChunkCall& call, PlannedPhotos& planned, Messages& messages) {
    const PhotoChunkPlan& plan = planned.plan;
    const auto [first, end] = plan.photosOf(call.number);
    requirePhotos(plan, first, end);
    const std::string name = "chunk " + std::to_string(call.number);
    if (isPhotoChunkMade(plan, call.folder, call.number)) {
        logLine(call, name + " is made already");
        messages.say(call.folder.string() + ": " + name + " is made already");
        return kExitDone;
    }
    logLine(call, "begins " + name);
    PhotoPlan slice;
    slice.batch = true;
    slice.items.assign(planned.photos.items.begin() + static_cast<std::ptrdiff_t>(first),
                       planned.photos.items.begin() + static_cast<std::ptrdiff_t>(end));
    checkedOutputs(*planned.commandLine, slice, planned.settings->display,
                   planned.settings->layout.viewCount, true)
        .makeDirectories();
    const auto start = std::chrono::steady_clock::now();
    PhotoChunkRecord record;
    record.host = hostName();
    FolderRun folder("photo", slice.items.size(), {}, messages);
    int made = 0;
    bool isOfMachine = false;
    for (const PhotoItem& item : slice.items) {
        record.photos.push_back(makePhoto(item, planned, folder, messages));
        const PhotoResult& result = record.photos.back();
        made += result.end == PhotoResult::End::Made ? 1 : 0;
        isOfMachine = isOfMachine || result.isOfMachine;
        if (result.end == PhotoResult::End::LeftOut)
            logLine(call, item.photo.string() + ": " + result.text);
        if (result.end == PhotoResult::End::Failed) logLine(call, "failed: " + result.text);
    }
    folder.end();
    record.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    record.peakMegabytes = peakMegabytes();
    record.depth = depthReport(*planned.commandLine, planned.run->depth);
    requirePhotos(plan, first, end); // they have not changed meanwhile
    // Another process may have made the same chunk meanwhile.
    if (!isOfMachine || !isPhotoChunkMade(plan, call.folder, call.number))
        writePhotoChunk(plan, call.folder, call.number, record);
    logLine(call, "made " + std::to_string(made) + " of " + counted(slice.items.size(), "photo") +
                      " in " + fixed(record.seconds, 1) + " s");
    return isOfMachine ? kExitFailed : kExitDone;
}

// "2, 4 and 3 more"
std::string listed(const std::vector<int>& numbers) {
    constexpr std::size_t kMost = 10;
    std::string text;
    for (std::size_t i = 0; i < std::min(numbers.size(), kMost); ++i)
        text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
    if (numbers.size() > kMost) text += " and " + std::to_string(numbers.size() - kMost) + " more";
    return text;
}

std::vector<PhotoChunkRecord> readAll(const PhotoChunkPlan& plan, const fs::path& folder) {
    std::vector<PhotoChunkRecord> records;
    std::vector<int> missing;
    for (int number = 1; number <= plan.chunks(); ++number) {
        std::optional<PhotoChunkRecord> record = readPhotoChunk(plan, folder, number);
        if (!record) {
            missing.push_back(number);
            continue;
        }
        requireOutputs(*record, number);
        records.push_back(std::move(*record));
    }
    if (!missing.empty()) {
        throw Error(ErrorCode::NotFound, folder.string(),
                    "has no " + std::string(missing.size() == 1 ? "chunk " : "chunks ") +
                        listed(missing) + " yet, expected chunks 1.." +
                        std::to_string(plan.chunks()));
    }
    return records;
}

// The report of a run on one machine; its times are those of the plan and of the chunks.
Json joinedReport(const PhotoChunkPlan& plan, const std::vector<PhotoChunkRecord>& records,
                  const std::vector<std::string>& warnings) {
    Json report = plan.report;
    const auto loaded =
        std::find_if(records.begin(), records.end(), [](const PhotoChunkRecord& record) {
            return !record.depth.at("network").is_null();
        });
    const Json& depth = (loaded == records.end() ? records.front() : *loaded).depth;
    for (const auto& part : depth.items())
        report["settings"][part.key()] = part.value();
    report["warnings"] = warnings;
    double peak = 0;
    Json pictures = Json::array();
    for (const PhotoChunkRecord& record : records) {
        peak = std::max(peak, record.peakMegabytes);
        for (const PhotoResult& photo : record.photos)
            pictures.push_back(photo.report);
    }
    report["peakMegabytes"] = peak;
    report["pictures"] = std::move(pictures);
    return report;
}

// What a chunk has said about a photo is said again, as a run on one machine says it.
void repeat(const PhotoItem& item, const PhotoResult& result, FolderRun& folder,
            Messages& messages) {
    folder.convert(item.photo, [&] {
        if (result.end == PhotoResult::End::LeftOut)
            throw NotTaken{{item.photo, result.kind, result.text}};
        if (result.end == PhotoResult::End::Failed) throw std::runtime_error(result.text);
        messages.warn(result.warnings);
        return kExitDone;
    });
}

int join(const ChunkCall& call, const PlannedPhotos& planned, Messages& messages) {
    const PhotoChunkPlan& plan = planned.plan;
    requirePhotos(plan, 0, plan.inputs.files.size());
    const std::vector<PhotoChunkRecord> records = readAll(plan, call.folder);
    Messages said(planned.commandLine->name(), false);
    said.warn(plan.warnings);
    for (const LeftOutFile& other : plan.inputs.leftOut) {
        if (other.kind != FileKind::Native) said.say(other.file.string() + ": " + other.why);
    }
    messages.dropWarnings(); // they are among those of the plan
    FolderRun folder("photo", planned.photos.items.size(), plan.inputs.leftOut, said);
    double seconds = 0;
    std::size_t at = 0;
    for (const PhotoChunkRecord& record : records) {
        seconds += record.seconds;
        for (const PhotoResult& photo : record.photos)
            repeat(planned.photos.items[at++], photo, folder, said);
    }
    if (!planned.photos.report.empty())
        writeFile(planned.photos.report, reportText(joinedReport(plan, records, said.warnings())));
    const int status = folder.end(fixed(seconds, seconds < 10 ? 1 : 0) + " s of work in " +
                                  counted(records.size(), "chunk"));
    logLine(call, "joined " + counted(records.size(), "chunk"));
    return status;
}

} // namespace

void addPhotoChunkOptions(CommandLine& commandLine) {
    addChunkOptions(commandLine, kLength,
                    "Photos of a chunk of --plan (default " + std::to_string(kChunkPhotos) +
                        ", about a minute).",
                    "N",
                    "Check the chunks of the plan in this folder, and write the summary and the "
                    "report of the whole run.");
}

bool isForPhotoChunks(const CommandLine& commandLine) {
    return isForChunks(commandLine, kLength);
}

int runPhotoChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
                   const std::function<void(CommandLine&)>& addOptions, Messages& messages) {
    const ChunkCall call = chunkCall(commandLine);
    if (call.task == ChunkCall::Task::Plan)
        return plan(commandLine, arguments, call.folder, messages);
    return runLogged(call, [&] {
        PlannedPhotos planned;
        openPlanned(call, commandLine.name(), addOptions, planned, messages);
        return call.task == ChunkCall::Task::Chunk ? makeChunk(call, planned, messages)
                                                   : join(call, planned, messages);
    });
}

} // namespace altiro3D::tools
