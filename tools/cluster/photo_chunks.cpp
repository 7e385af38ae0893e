#include "cluster/photo_chunks.hpp"

#include "altiro3D/altiro3D.hpp"
#include "cli/folders.hpp"
#include "cli/json_text.hpp"
#include "cluster/chunk_folder.hpp"

#include <algorithm>
#include <chrono>
#include <opencv2/core.hpp>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

namespace {

constexpr const char* kLength = "chunk-photos";
constexpr int kChunkPhotos = 100; // of 0.2 to 1 s each
constexpr int kMaxChunkPhotos = 1000000;
constexpr const char* kChunks = "chunks";
constexpr const char* kLogs = "logs";
constexpr std::size_t kHead = 4; // words of the list before the photos, of three words each

fs::path listFile(const fs::path& folder) {
    return folder / "photos";
}

fs::path recordFile(const fs::path& folder, int number) {
    return folder / kChunks / std::to_string(number);
}

std::string madeWith(const PhotoRun& run) {
    const fs::path& network = run.depthSource.networkFile();
    return "version " + std::string(version()) + ", OpenCV " + CV_VERSION + ", display " +
           fingerprintText(run.display.map ? run.display.map->calibrationFingerprint()
                                           : fingerprint(run.display.calibration)) +
           ", depth by " + run.depthSource.description() +
           (network.empty() ? "" : " of " + std::to_string(fs::file_size(network)) + " bytes");
}

// The call is there only to tell whether a plan is the same.
Words listWords(const PhotoChunks& plan, const Words& call) {
    std::string text = fs::current_path().string();
    for (const std::string& word : call)
        text += " " + shellWord(word);
    Words words = {plan.madeWith, text, std::to_string(plan.threads),
                   std::to_string(plan.chunkPhotos)};
    for (const FolderFile& photo : plan.photos) {
        for (const fs::path& part : {photo.file, photo.depth, photo.folder})
            words.push_back(part.string());
    }
    return words;
}

void makeFolders(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error) && fs::exists(folder, error))
        throw Error(ErrorCode::WriteFailed, folder.string(), "is a file, expected a new folder");
    if (fs::is_directory(folder, error) && !fs::is_empty(folder, error)) {
        throw Error(ErrorCode::WriteFailed, folder.string(),
                    "holds other files, expected a new folder");
    }
    for (const char* name : {kChunks, kLogs}) {
        fs::create_directories(folder / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (folder / name).string(),
                        "cannot be made: " + error.message() + ", expected a folder to write to");
        }
    }
}

int plan(const PhotoJob& job, int chunkPhotos, const Words& arguments, const fs::path& folder,
         Messages& messages) {
    PhotoChunks plan;
    plan.chunkPhotos = chunkPhotos;
    const ChosenDisplay display = findDisplay(job.display, messages);
    const QuiltLayout layout = chooseQuilt(job.quilt, display, messages);
    const PhotoInputs inputs = listPhotos(job, messages);
    if (!inputs.batch) {
        throw UsageError("--plan applies to several photos, expected a folder or several photos, "
                         "and a folder for the outputs");
    }
    PhotoPlan photos = planPhotos(job, display, layout, inputs);
    StageTimes times;
    plan.madeWith = madeWith(openPhotoRun(job, display, layout, times, messages));
    plan.threads = cv::getNumThreads();
    plan.photos = inputs.files;
    const Words words = listWords(plan, arguments);
    const bool replace = job.replace;
    const bool isThere = holdsPhotoChunks(folder);
    if (!isThere || replace || readWords(listFile(folder)) != words) {
        if (isThere && !replace) {
            throw Error(ErrorCode::Mismatch, folder.string(),
                        "holds a plan of another run, expected a new folder, or -y to replace it");
        }
        static_cast<void>(checkedOutputs(job, photos, display, layout.viewCount));
        if (isThere) {
            for (const char* name : {"photos", "arguments", "visual.json", kChunks, kLogs})
                fs::remove_all(folder / name);
        }
        makeFolders(folder);
        keepCommandLine(folder, arguments, job.display, display);
        writeWords(listFile(folder), words);
    }
    messages.say(folder.string() + ": " + counted(plan.count(), "chunk") + ", " +
                 counted(plan.photos.size(), "photo"));
    return kExitDone;
}

void logPhotos(const ChunkCall& call, const PhotosMade& made) {
    for (const std::string& line : made.notMade)
        logLine(call, line);
}

int makeChunk(const ChunkCall& call, const std::function<PhotosMade()>& make, Messages& messages) {
    const std::string name = "chunk " + std::to_string(call.number);
    if (isPhotoChunkMade(call.folder, call.number)) {
        logLine(call, name + " is made already");
        messages.say(call.folder.string() + ": " + name + " is made already");
        return kExitDone;
    }
    logLine(call, "begins " + name);
    const auto start = std::chrono::steady_clock::now();
    const PhotosMade made = make();
    logPhotos(call, made);
    Words outputs;
    for (const fs::path& file : made.outputs)
        outputs.push_back(fs::absolute(file).string());
    const bool isWhole = !made.mayRecover && made.status != kExitStopped;
    if (isWhole) writeWords(recordFile(call.folder, call.number), outputs);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    logLine(call, "ends " + name + ", in " + fixed(spent.count(), 1) + " s");
    return made.status == kExitStopped ? kExitStopped : isWhole ? kExitDone : kExitFailed;
}

std::set<std::string> outputsOfChunks(const fs::path& folder, int count) {
    std::set<std::string> outputs;
    for (int number = 1; number <= count; ++number) {
        const Words words = readWords(recordFile(folder, number));
        outputs.insert(words.begin(), words.end());
    }
    return outputs;
}

void requireChunks(const fs::path& folder, int count) {
    std::vector<int> missing;
    for (int number = 1; number <= count; ++number)
        if (!isPhotoChunkMade(folder, number)) missing.push_back(number);
    if (missing.empty()) return;
    throw Error(ErrorCode::NotFound, folder.string(),
                "has no " + std::string(missing.size() == 1 ? "chunk " : "chunks ") +
                    rangesText(missing) + " yet, expected chunks 1.." + std::to_string(count));
}

} // namespace

int PhotoChunks::count() const {
    const auto most = static_cast<std::size_t>(chunkPhotos);
    return static_cast<int>((photos.size() + most - 1) / most);
}

std::pair<std::size_t, std::size_t> PhotoChunks::photosOf(int number) const {
    if (number < 1 || number > count()) {
        throw Error(ErrorCode::InvalidArgument, "chunk",
                    "is " + std::to_string(number) + ", expected 1.." + std::to_string(count()));
    }
    const auto most = static_cast<std::size_t>(chunkPhotos);
    const std::size_t first = static_cast<std::size_t>(number - 1) * most;
    return {first, std::min(first + most, photos.size())};
}

bool holdsPhotoChunks(const fs::path& folder) {
    return isThere(listFile(folder));
}

PhotoChunks readPhotoChunks(const fs::path& folder) {
    if (!holdsPhotoChunks(folder)) {
        throw Error(ErrorCode::NotFound, folder.string(),
                    "holds no plan of photos, expected the folder of a plan");
    }
    const Words words = readWords(listFile(folder));
    PhotoChunks plan;
    if (words.size() > kHead) {
        plan.madeWith = words[0];
        plan.threads = QString::fromStdString(words[2]).toInt(); // 0 if it is no number
        plan.chunkPhotos = QString::fromStdString(words[3]).toInt();
    }
    for (std::size_t i = kHead; i + 2 < words.size(); i += 3)
        plan.photos.push_back({words[i], words[i + 1], words[i + 2]});
    if (words.size() != kHead + 3 * plan.photos.size() || plan.photos.empty() || plan.threads < 1 ||
        plan.threads > 1 << 20 || plan.chunkPhotos < 1 || plan.chunkPhotos > kMaxChunkPhotos) {
        failDamaged(listFile(folder));
    }
    return plan;
}

bool isPhotoChunkMade(const fs::path& folder, int number) {
    const fs::path file = recordFile(folder, number);
    if (!isThere(file)) return false;
    try {
        const Words outputs = readWords(file);
        return std::all_of(outputs.begin(), outputs.end(), isFileWithContents);
    } catch (const Error&) {
        return false; // it is made again
    }
}

void PhotoPart::keepOwn(PhotoPlan& photos) const {
    const auto begin = photos.items.begin();
    photos.items = {begin + static_cast<std::ptrdiff_t>(first),
                    begin + static_cast<std::ptrdiff_t>(end)};
}

void PhotoPart::markOutdated(PhotoPlan& photos) const {
    if (!made) return;
    for (PhotoItem& item : photos.items)
        item.isMade = item.isMade && made->count(fs::absolute(item.native).string()) != 0;
}

void PhotoPart::requireSame(const PhotoRun& run) const {
    const std::string now = madeWith(run);
    if (now == chunks.madeWith) return;
    throw Error(ErrorCode::Mismatch, "the plan",
                "was made with other settings (" + chunks.madeWith + "), expected the same, not " +
                    now);
}

void addPhotoChunkOptions(CommandLine& commandLine) {
    addChunkOptions(commandLine, kLength,
                    "Photos of a chunk of --plan (default " + std::to_string(kChunkPhotos) +
                        ", about a minute).",
                    "N",
                    "Check the chunks of the plan in this folder, try the photos again that "
                    "failed, and write the summary and the report.");
}

std::optional<int>
runPhotoChunks(const CommandLine& commandLine, const Words& arguments,
               const std::function<void(CommandLine&)>& addOptions,
               const std::function<PhotosMade(const PhotoJob&, const PhotoPart&)>& make,
               Messages& messages) {
    const std::optional<ChunkCall> called = chunkCall(commandLine, kLength);
    if (!called) return std::nullopt;
    const ChunkCall& call = *called;
    const bool json = wantsJsonProgress(commandLine);
    if (json) messages.leaveStandardOutput();
    if (call.task == ChunkCall::Task::Plan) {
        commandLine.exclude("plan", "budget");
        int photos = kChunkPhotos;
        commandLine.take({{kLength, photos, 1, kMaxChunkPhotos}});
        const PhotoJob job = photoJob(commandLine);
        if (job.outputs.native.empty())
            throw UsageError("--plan takes photos and a folder for the Natives, expected its name");
        return plan(job, photos, arguments, call.folder, messages);
    }
    return runLogged(call, [&] {
        PhotoPart part;
        part.chunks = readPhotoChunks(call.folder);
        const bool isJoin = call.task == ChunkCall::Task::Join;
        std::tie(part.first, part.end) = isJoin
                                             ? std::pair(std::size_t{0}, part.chunks.photos.size())
                                             : part.chunks.photosOf(call.number);
        if (isJoin) requireChunks(call.folder, part.chunks.count());
        int status = kExitDone;
        const auto work = [&](const CommandLine& given) {
            PhotoJob planned = photoJob(given);
            planned.jsonProgress = json;
            planned.skipExisting = isJoin || !planned.replace; // else what exists is older
            if (isJoin) {
                if (planned.replace) part.made = outputsOfChunks(call.folder, part.chunks.count());
                const PhotosMade made = make(planned, part);
                logPhotos(call, made);
                logLine(call, "joined " + counted(part.chunks.count(), "chunk"));
                status = made.status;
                return;
            }
            if (!planned.report.empty())
                planned.report = call.folder / kLogs / (call.logName() + ".json");
            status = makeChunk(
                call, [&] { return make(planned, part); }, messages);
        };
        openCommandLine(call.folder, commandLine.name(), part.chunks.threads, addOptions, work);
        return status;
    });
}

} // namespace altiro3D::tools
