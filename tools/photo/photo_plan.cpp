#include "photo/photo_plan.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/folders.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"

#include <algorithm>
#include <set>

namespace altiro3D::tools {

namespace fs = std::filesystem;

const std::vector<OutputKind>& outputKinds() {
    static const std::vector<OutputKind> kinds = {
        {"save-quilt", &PhotoOutputs::quilt, ".png"},
        {"save-depth", &PhotoOutputs::savedDepth, "_depth.png"},
        {"save-rgbd", &PhotoOutputs::rgbd, "_rgbd.png"},
        {"save-photo-with-depth", &PhotoOutputs::photoWithDepth, "_with_depth.jpg"},
        {"lg", &PhotoOutputs::video, ".mp4"},
        {"save-views", &PhotoOutputs::views, "_views", false},
        {"save-splats", &PhotoOutputs::splats, ".ply"},
        {"save-page", &PhotoOutputs::page, ".html"},
        {"save-stereo", &PhotoOutputs::stereo, "", false}}; // by its layout
    return kinds;
}

namespace {

// Explains the purpose of a file that cannot be a photo.
void requirePhotoName(const fs::path& name) {
    const std::string extension = name.extension().string();
    const char* hint = nullptr;
    if (extension == ".json") hint = "a calibration is given with -c";
    if (extension == ".map") hint = "a look-up table is given with -m";
    if (extension == ".onnx") hint = "a network is given with -n";
    if (isVideoFileName(name)) hint = "video2native makes Natives of videos";
    if (isSplatFileName(name)) hint = "splat2native makes Natives of scenes of splats";
    if (hint == nullptr || isDirectory(name)) return;
    throw UsageError(name.string() + ": is not a picture, expected a photo; " + hint);
}

bool isJpegName(const fs::path& name) {
    const std::string extension = lowerExtension(name);
    return extension == ".jpg" || extension == ".jpeg";
}

std::string pairName(const DepthOptions& depth) {
    return depth.fromFiles ? "PHOTO DEPTH" : "LEFT RIGHT";
}

// The folder at a relative path in another one. Where no folder has exactly the name, one with a
// comparable name takes its place, see comparableName().
fs::path folderIn(fs::path folder, const fs::path& relative) {
    for (const fs::path& name : relative) {
        const std::u32string comparable = comparableName(name.string());
        fs::path alike;
        std::error_code error;
        fs::directory_iterator entry(folder, error);
        for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
            const fs::path& other = entry->path();
            if (comparableName(other.filename().string()) == comparable && isDirectory(other) &&
                (alike.empty() || other < alike))
                alike = other;
        }
        folder = isDirectory(folder / name) || alike.empty() ? folder / name : alike;
    }
    return folder;
}

// Pairs the photos of one folder with the depth images or right eyes' pictures of another one.
// These are named as the photos, or as depth images beside photos are (a-depth.png).
std::vector<FolderFile> pairsOf(const fs::path& photos, const fs::path& others,
                                const FolderSearch& search, std::vector<LeftOutFile>& leftOut,
                                Messages& messages) {
    std::vector<FolderFile> inputs = listFiles(photos, search, leftOut, messages);
    std::vector<NamedDepth> depths;
    std::vector<NamedDepth> longer; // a-depth.png
    std::set<fs::path> listed;
    for (const FolderFile& input : inputs) {
        const fs::path folder = folderIn(others, input.folder);
        if (!listed.insert(folder).second || !isDirectory(folder)) continue;
        for (const fs::path& depth : listImages(folder)) {
            depths.push_back({depth, input.file.parent_path() / depth.stem()});
            if (const fs::path photo = photoOfDepthName(depth).filename(); !photo.empty())
                longer.push_back({depth, input.file.parent_path() / photo});
        }
    }
    depths.insert(depths.end(), longer.begin(), longer.end());
    for (const SpareDepth& spare : pairDepthImages(depths, inputs)) {
        const bool isUsed = std::any_of(inputs.begin(), inputs.end(), [&](const FolderFile& input) {
            return input.depth == spare.file;
        });
        if (!isUsed && !spare.why.empty())
            messages.warn(spare.file.string() + ": is not used, as " + spare.why);
    }
    for (FolderFile& input : inputs)
        if (input.depth.empty())
            input.depth = others / input.folder / input.file.filename(); // fails by name
    return inputs;
}

// The photos (and depths) among the names.
std::vector<FolderFile> inputsOf(const PhotoJob& job, std::vector<LeftOutFile>& leftOut,
                                 Messages& messages) {
    const std::vector<fs::path>& names = job.inputs;
    const bool pairs = job.depth.takesPairs();
    FolderSearch search;
    search.recursive = job.recursive;
    search.pairDepth = job.depth.given.empty() && !job.depth.stereo;
    search.leavesOutVr = job.depth.refusesVr;
    if (!job.outputs.native.empty()) search.outputs.push_back(job.outputs.native);
    if (!job.plan.empty()) search.outputs.push_back(job.plan);
    for (const OutputKind& kind : outputKinds()) {
        if (const fs::path& directory = job.outputs.*kind.file; !directory.empty())
            search.outputs.push_back(directory);
    }
    std::vector<FolderFile> inputs;
    if (pairs && names.size() == 2 && isDirectory(names[0]) && isDirectory(names[1])) {
        search.outputs.push_back(names[1]);
        inputs = pairsOf(names[0], names[1], search, leftOut, messages);
    } else if (pairs) {
        for (std::size_t i = 0; i < names.size(); i += 2)
            inputs.push_back({names[i], names[i + 1], {}});
    } else {
        for (const fs::path& name : names) {
            if (isStandardStream(name) || !isDirectory(name)) {
                inputs.push_back({name});
                continue;
            }
            for (FolderFile& photo : listFiles(name, search, leftOut, messages)) {
                if (!job.depth.stored.useDepth) photo.depth.clear();
                inputs.push_back(photo);
            }
        }
    }
    if (inputs.empty())
        throw Error(
            ErrorCode::NotFound, names.front().string(),
            "holds no pictures to convert, expected photos" +
                (leftOut.empty() ? std::string() : " (left out: " + kindsText(leftOut) + ")"));
    return inputs;
}

// The names on the command line: photos, and the output. One photo, or one folder, needs none if
// it has other outputs.
void takeNames(const CommandLine& commandLine, PhotoJob& job) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pairs = job.depth.takesPairs();
    const std::size_t least = pairs ? 3 : 2;
    if (job.go) {
        if (names.size() + 1 < least)
            commandLine.failNames(pairs ? pairName(job.depth) : "PHOTO", least - 1);
        job.inputs = names;
        return;
    }
    // if it does not exist, an option may have taken the photo's name for its value
    const bool isAlone = job.hasOthers() && names.size() + 1 == least &&
                         (isStandardStream(names.front()) || isThere(names.front()));
    const std::size_t outputs = isAlone ? 0 : 1;
    if (names.size() + 1 < least + outputs)
        commandLine.failNames(pairs ? pairName(job.depth) + " OUT" : "PHOTO and OUT", least);
    job.inputs.assign(names.begin(), names.end() - static_cast<std::ptrdiff_t>(outputs));
    if (outputs > 0) job.outputs.native = names.back();
    for (const fs::path& name : job.inputs)
        requirePhotoName(name);
    if (pairs && job.inputs.size() % 2 != 0)
        throw UsageError((job.depth.fromFiles ? "-d" : "--stereo files") +
                         (" takes pairs " + pairName(job.depth)) + " and one output, got " +
                         counted(names.size(), "name") + "; see photo2native --help");
}

} // namespace

bool OutputJob::hasOthers() const {
    const std::vector<OutputKind>& kinds = outputKinds();
    return std::any_of(kinds.begin(), kinds.end(),
                       [&](const OutputKind& kind) { return !(outputs.*kind.file).empty(); });
}

void takeOutputs(const CommandLine& commandLine, OutputJob& job) {
    job.sway = swayOptions(commandLine);
    job.swaySize = swaySizeOption(commandLine).value_or(cv::Size());
    requireSwayFile(commandLine);
    job.display = displayOptions(commandLine);
    job.print = printOptions(commandLine);
    job.quilt = quiltRequest(commandLine);
    commandLine.exclude("y", "skip-existing");
    commandLine.take({{"y", job.replace},
                      {"skip-existing", job.skipExisting},
                      {"recursive", job.recursive},
                      {"report", job.report}});
    job.jsonProgress = wantsJsonProgress(commandLine);
    for (const OutputKind& kind : outputKinds())
        job.outputs.*kind.file = commandLine.value(kind.option).value_or("");
    job.go = GoFolder::of(commandLine);
    if (job.go) {
        for (const OutputKind& kind : outputKinds())
            commandLine.exclude("go", kind.option);
        commandLine.exclude("go",
                            {"plan", "skip-existing", "m", "c", "serial", "invert", "q", "r"});
        job.outputs.quilt = job.go->content();
    }
    job.bridge = bridgeJob(commandLine);
    job.quiltIsForBridge = job.bridge && job.outputs.quilt.empty() && job.outputs.rgbd.empty();
    if (job.quiltIsForBridge) job.outputs.quilt = cacheDirectory() / "bridge";
    job.eyes = EyesFiles(commandLine);
    job.page = PageOptions(commandLine);
}

PhotoJob photoJob(const CommandLine& commandLine) {
    PhotoJob job;
    job.budget = Budget(commandLine);
    job.scene = sceneOptions(commandLine, AutoUse::Photos);
    job.camera = CameraOptions(commandLine, job.scene.recipe.views.method);
    takeOutputs(commandLine, job);
    commandLine.exclude("print", "plan");
    commandLine.exclude("go", {"view-filter", "sampling"});
    if (job.bridge) commandLine.exclude("bridge", {"plan", "m"});
    job.isStrengthGiven =
        commandLine.has("camera") || commandLine.value("strength").value_or("auto") != "auto";
    job.depth = depthOptions(commandLine);
    for (const char* other : {"strength", "focus", "depth-curve", "stereo-keep", "method"})
        job.keepsEyes = job.keepsEyes && !commandLine.has(other);
    takeNames(commandLine, job);
    const bool areEyesAlone = job.outputs.video.empty() && displayUse(job) == DisplayUse::None;
    if (!job.outputs.stereo.empty() && areEyesAlone)
        commandLine.refuse({"center", "zoom", "fit"},
                           " chooses a part for a panel, but eyes see whole photos; leave it out");
    if (isStandardStream(job.outputs.native))
        commandLine.refuse({"progress"}, " writes to standard output, expected the name of a file "
                                         "for the Native");
    if (job.print && displayUse(job) != DisplayUse::Show)
        throw UsageError("--print makes a print, expected OUT, the name of its file");
    job.savedDepthSide =
        commandLine.wholeNumber("save-depth-size", 16, 65500).value_or(kSavedDepthSide);
    if (!commandLine.has("save-depth") && !commandLine.has("save-photo-with-depth"))
        commandLine.refuse({"save-depth-size"}, " is the size of saved depth, expected "
                                                "--save-depth or --save-photo-with-depth with it");
    commandLine.take(
        {{"splat-side", job.splatSide, 16, 8192}, {"splat-camera", job.keepsSplatCamera}});
    commandLine.refuseWithout("save-splats", {"splat-side", "splat-camera"},
                              " describes saved splats, expected --save-splats with it");
    job.plan = commandLine.value("plan").value_or("");
    const auto given = commandLine.given();
    job.given = {given.begin(), given.end()};
    return job;
}

DisplayUse displayUse(const PhotoJob& job) {
    const PhotoOutputs& outputs = job.outputs;
    if (!outputs.native.empty()) return DisplayUse::Show;
    return outputs.quilt.empty() && outputs.views.empty() ? DisplayUse::None : DisplayUse::Quilt;
}

const fs::path& mainOutput(const PhotoItem& item) {
    const std::vector<OutputKind>& kinds = outputKinds();
    const auto other = std::find_if(kinds.begin(), kinds.end(), [&](const OutputKind& kind) {
        return !(item.*kind.file).empty();
    });
    return item.native.empty() ? item.*(other->file) : item.native;
}

std::vector<fs::path> outputsOf(const PhotoItem& item, int views) {
    std::vector<fs::path> files;
    if (!item.native.empty()) files.push_back(item.native);
    for (const OutputKind& kind : outputKinds()) {
        const fs::path& file = item.*kind.file;
        if (!file.empty() && kind.isOneFile) files.push_back(file);
    }
    for (const fs::path& file : item.eyes.files())
        files.push_back(file);
    for (int i = 0; i < views && !item.views.empty(); ++i)
        files.push_back(item.views / viewFileName(i, views));
    return files;
}

PhotoInputs listPhotos(const PhotoJob& job, Messages& messages) {
    const bool pairs = job.depth.takesPairs();
    const fs::path& output = job.outputs.native;
    PhotoInputs inputs;
    inputs.batch = job.go || job.inputs.size() > (pairs ? 2 : 1) ||
                   (!isStandardStream(output) && isDirectory(output)) ||
                   (!isStandardStream(job.inputs.front()) && isDirectory(job.inputs.front()));
    const auto streams = std::count(job.inputs.begin(), job.inputs.end(), "-");
    if ((inputs.batch && (streams > 0 || isStandardStream(output))) || streams > 1)
        throw UsageError("- stands for one picture, expected names of files and of a directory "
                         "for several photos");
    inputs.files = inputsOf(job, inputs.leftOut, messages);
    if (inputs.batch && !output.empty())
        requireDirectoryName(output, "photos",
                             job.inputs.size() == 2 && !pairs ? ", or -d with a photo and its depth"
                                                              : "");
    return inputs;
}

PhotoPlan planPhotos(const OutputJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                     const PhotoInputs& inputs) {
    PhotoPlan plan{inputs, {}};
    for (const OutputKind& kind : outputKinds()) {
        const fs::path& name = job.outputs.*kind.file;
        const bool namesFile = &name != &job.outputs.views && !name.empty() &&
                               (canWriteImage(name) || canWriteVideo(name) || isPageFileName(name));
        if (plan.batch && namesFile)
            throw UsageError("--" + std::string(kind.option) + " " + name.string() +
                             ": names one file, expected a directory for the outputs of several " +
                             job.things);
    }
    const std::vector<std::string> stems = outputStems(inputs.files);
    for (std::size_t i = 0; i < inputs.files.size(); ++i) {
        PhotoItem item{job.outputs, inputs.files[i].file, inputs.files[i].depth,
                       EyesFiles(job.eyes, job.outputs.stereo)};
        item.isFromFolder =
            std::find(job.inputs.begin(), job.inputs.end(), item.photo) == job.inputs.end();
        if (plan.batch) {
            if (!item.native.empty()) item.native /= stems[i] + "_native.png";
            for (const OutputKind& kind : outputKinds())
                if (!(item.*kind.file).empty()) item.*kind.file /= stems[i] + kind.ending;
            if (!item.stereo.empty()) {
                item.stereo += job.eyes.ending();
                item.eyes = EyesFiles(job.eyes, item.stereo);
            }
        } else { // of several, one that is bad does not stop the rest
            if (!isStandardStream(item.photo)) requireFile(item.photo);
            if (!item.depth.empty()) requireFile(item.depth);
        }
        if (job.quiltIsForBridge) {
            const bool isInCache =
                job.hasOwnViews || item.native.empty() || isStandardStream(item.native);
            item.quilt = isInCache ? quiltForBridge(stems[i])
                                   : item.native.parent_path() / (stems[i] + ".png");
        }
        if (job.go) {
            item.quilt = job.go->quiltFile(i, stems[i]);
        } else if (!item.quilt.empty()) {
            const auto named = parseQuiltName(item.quilt);
            const bool isNamed = named && named->aspect && !job.hasOwnViews;
            const double aspect = isNamed ? *named->aspect : display.aspect();
            item.quilt = quiltFileName(item.quilt, layout, aspect);
        }
        plan.items.push_back(item);
    }
    return plan;
}

Outputs checkedOutputs(const PhotoJob& job, PhotoPlan& plan, const ChosenDisplay& display,
                       int views) {
    return checkedOutputs(job, plan, display, views,
                          {job.depth.network, job.depth.profile, job.camera.file()});
}

Outputs checkedOutputs(const OutputJob& job, PhotoPlan& plan, const ChosenDisplay& display,
                       int views, const Outputs::Files& alsoRead) {
    // incomplete sets of outputs and the report are made again
    Outputs outputs(job.replace || job.skipExisting);
    outputs.addInputs(display.files);
    outputs.addInputs(alsoRead);
    for (PhotoItem& item : plan.items) {
        outputs.addInputs({item.photo, item.depth});
        requireNoTerminal(item.native);
        for (const fs::path& file :
             {item.native, item.quilt, item.savedDepth, item.rgbd, item.stereo}) {
            if (!file.empty() && file == item.native && job.print) {
                requireNativeName(file, true);
            } else if (!file.empty() && !isStandardStream(file)) {
                requirePictureName(file, file != item.savedDepth);
            }
        }
        if (!item.photoWithDepth.empty() && !isJpegName(item.photoWithDepth))
            throw UsageError("--save-photo-with-depth " + item.photoWithDepth.string() +
                             ": is not the name of a JPEG, expected FILE.jpg");
        if (!item.video.empty()) requireVideoName(item.video);
        requireSplatName(item.splats);
        requirePageName(item.page);
        if (!item.views.empty()) outputs.addDirectory(item.views);
        const std::vector<fs::path> files = outputsOf(item, views);
        if (job.quiltIsForBridge && (item.native.empty() || job.hasOwnViews))
            outputs.addDirectory(item.quilt.parent_path());
        for (const fs::path& file : files) {
            if (plan.batch) outputs.addDirectory(file.parent_path());
            if (file == item.native && !plan.batch && job.makesNative) {
                outputs.addNative(file);
            } else {
                outputs.addOutputs({file});
            }
        }
        item.isMade =
            job.skipExisting && std::all_of(files.begin(), files.end(), isFileWithContents);
    }
    outputs.addOutputs({job.report});
    outputs.check();
    return outputs;
}

} // namespace altiro3D::tools
