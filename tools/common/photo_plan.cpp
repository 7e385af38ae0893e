#include "common/photo_plan.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "common/folder_run.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// False for names that cannot be looked up; opening them reports the reason.
bool isDirectory(const fs::path& name) {
    std::error_code error;
    return fs::is_directory(name, error);
}

// Explains the purpose of a file that cannot be a photo.
void requirePhotoName(const fs::path& name) {
    const std::string extension = name.extension().string();
    const char* hint = nullptr;
    if (extension == ".json") hint = "a calibration is given with -c";
    if (extension == ".map") hint = "a look-up table is given with -m";
    if (extension == ".onnx") hint = "a network is given with -n";
    if (isVideoFileName(name)) hint = "video2native makes Natives of videos";
    if (hint == nullptr || isDirectory(name)) return;
    throw UsageError(name.string() + ": is not a picture, expected a photo; " + hint);
}

bool isJpegName(const fs::path& name) {
    const std::string extension = lowerCase(name.extension().string());
    return extension == ".jpg" || extension == ".jpeg";
}

// Several outputs of one kind go into a directory, one alone has the name that was given.
fs::path outputName(const std::optional<std::string>& wanted, bool batch, const std::string& stem,
                    const std::string& ending) {
    if (!wanted) return {};
    return batch ? fs::path(*wanted) / (stem + ending) : fs::path(*wanted);
}

// Two names for each photo: its depth image, or the right eye's picture.
bool takesPairs(const CommandLine& commandLine) {
    return commandLine.has("d") || commandLine.value("stereo") == "files";
}

// Whether depth images beside the photos are used.
bool takesStoredDepth(const CommandLine& commandLine) {
    if (const auto use = commandLine.value("embedded-depth")) return use != "off";
    return !commandLine.has("n") && !commandLine.has("l");
}

std::string pairName(const CommandLine& commandLine) {
    return commandLine.has("d") ? "PHOTO DEPTH" : "LEFT RIGHT";
}

// The photos (and depths) among the names; the last name is the output.
std::vector<FolderFile> inputsOf(const CommandLine& commandLine, std::vector<LeftOutFile>& leftOut,
                                 Messages& messages) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pairs = takesPairs(commandLine);
    std::vector<FolderFile> inputs;
    std::vector<fs::path> given(names.begin(), names.end() - 1);
    FolderSearch search;
    search.recursive = commandLine.has("recursive");
    search.pairDepth = !pairs && !commandLine.has("rgbd") && !commandLine.has("stereo");
    search.leavesOutVr = search.pairDepth && commandLine.value("embedded-depth") != "off";
    search.outputs = {names.back()};
    if (const auto folder = commandLine.value("plan")) search.outputs.emplace_back(*folder);
    for (const char* option :
         {"save-quilt", "save-depth", "save-rgbd", "save-photo-with-depth", "save-views", "lg"}) {
        if (const auto directory = commandLine.value(option))
            search.outputs.emplace_back(*directory);
    }
    if (pairs && given.size() == 2 && isDirectory(given[0]) && isDirectory(given[1])) {
        search.outputs.push_back(given[1]);
        std::map<fs::path, fs::path> depths; // by name without extension
        std::set<fs::path> listed;
        for (FolderFile& input : listFiles(given[0], search, leftOut, messages)) {
            const fs::path folder = input.folder.empty() ? given[1] : given[1] / input.folder;
            if (listed.insert(folder).second && isDirectory(folder)) {
                for (const fs::path& depth : listImages(folder))
                    depths[folder / depth.stem()] = depth;
            }
            auto found = depths.find(folder / input.file.stem());
            for (auto named = depths.begin(); found == depths.end() && named != depths.end();
                 ++named) // a-depth.png
                if (photoOfDepthName(named->second) == folder / input.file.stem()) found = named;
            input.depth = found != depths.end() ? found->second
                                                : folder / input.file.filename(); // fails by name
            inputs.push_back(input);
        }
    } else if (pairs) {
        if (given.size() % 2 != 0) {
            throw UsageError((commandLine.has("d") ? "-d" : "--stereo files") +
                             (" takes pairs " + pairName(commandLine)) + " and one output, got " +
                             counted(names.size(), "name") + "; see photo2native --help");
        }
        for (std::size_t i = 0; i < given.size(); i += 2)
            inputs.push_back({given[i], given[i + 1], {}});
    } else {
        for (const fs::path& name : given) {
            if (!isDirectory(name)) {
                inputs.push_back({name, {}, {}});
                continue;
            }
            for (FolderFile& photo : listFiles(name, search, leftOut, messages)) {
                if (!takesStoredDepth(commandLine)) photo.depth.clear();
                inputs.push_back(photo);
            }
        }
    }
    if (inputs.empty()) {
        throw Error(
            ErrorCode::NotFound, given.front().string(),
            "holds no pictures to convert, expected photos" +
                (leftOut.empty() ? std::string() : " (left out: " + kindsText(leftOut) + ")"));
    }
    return inputs;
}

} // namespace

std::vector<fs::path> outputsOf(const PhotoItem& item, int views) {
    std::vector<fs::path> files;
    for (const fs::path& file :
         {item.native, item.quilt, item.savedDepth, item.rgbd, item.photoWithDepth, item.video}) {
        if (!file.empty()) files.push_back(file);
    }
    if (!item.views.empty()) {
        for (int i = 0; i < views; ++i)
            files.push_back(item.views / viewFileName(i, views));
    }
    return files;
}

PhotoInputs listPhotos(const CommandLine& commandLine, Messages& messages) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pairs = takesPairs(commandLine);
    const std::size_t least = pairs ? 3 : 2;
    commandLine.exclude("y", "skip-existing");
    if (names.size() < least) {
        commandLine.failNames(pairs ? pairName(commandLine) + " OUT" : "PHOTO and OUT", least);
    }
    for (std::size_t i = 0; i + 1 < names.size(); ++i)
        requirePhotoName(names[i]);
    const fs::path& last = names.back();
    PhotoInputs inputs;
    inputs.files = inputsOf(commandLine, inputs.leftOut, messages);
    inputs.batch = names.size() > least || isDirectory(last) || isDirectory(names.front());
    if (inputs.batch) {
        requireDirectoryName(last, "photos",
                             names.size() == 3 && !pairs ? ", or -d with a photo and its depth"
                                                         : "");
    }
    return inputs;
}

PhotoPlan planPhotos(const CommandLine& commandLine, const ChosenDisplay& display,
                     const QuiltLayout& layout, const PhotoInputs& inputs) {
    const std::vector<fs::path>& names = commandLine.files();
    const fs::path& last = names.back();
    PhotoPlan plan;
    plan.leftOut = inputs.leftOut;
    plan.batch = inputs.batch;
    for (const char* option :
         {"save-quilt", "save-depth", "save-rgbd", "save-photo-with-depth", "lg"}) {
        const auto name = commandLine.value(option);
        if (plan.batch && name && (canWriteImage(*name) || canWriteVideo(*name))) {
            throw UsageError("--" + std::string(option) + " " + *name +
                             ": names one file, expected a directory for the outputs of several "
                             "photos");
        }
    }
    const std::vector<std::string> stems = outputStems(inputs.files);
    for (std::size_t i = 0; i < inputs.files.size(); ++i) {
        const fs::path& photo = inputs.files[i].file;
        const fs::path& depth = inputs.files[i].depth;
        const std::string& stem = stems[i];
        PhotoItem item;
        item.photo = photo;
        item.depth = depth;
        item.isFromFolder = std::find(names.begin(), names.end(), photo) == names.end();
        if (!plan.batch) requireFile(photo); // of several, one that is bad does not stop the rest
        if (!plan.batch && !depth.empty()) requireFile(depth);
        item.native = plan.batch ? last / (stem + "_native.png") : last;
        item.quilt = outputName(commandLine.value("save-quilt"), plan.batch, stem, ".png");
        item.savedDepth =
            outputName(commandLine.value("save-depth"), plan.batch, stem, "_depth.png");
        item.rgbd = outputName(commandLine.value("save-rgbd"), plan.batch, stem, "_rgbd.png");
        item.photoWithDepth = outputName(commandLine.value("save-photo-with-depth"), plan.batch,
                                         stem, "_with_depth.jpg");
        item.views = outputName(commandLine.value("save-views"), plan.batch, stem, "_views");
        item.video = outputName(commandLine.value("lg"), plan.batch, stem, ".mp4");
        if (!item.quilt.empty()) {
            const auto named = parseQuiltName(item.quilt);
            const double aspect = named && named->aspect ? *named->aspect : display.aspect();
            item.quilt = quiltFileName(item.quilt, layout, aspect);
        }
        plan.items.push_back(item);
    }
    plan.skipExisting = commandLine.has("skip-existing");
    plan.report = commandLine.value("report").value_or("");
    return plan;
}

Outputs checkedOutputs(const CommandLine& commandLine, PhotoPlan& plan,
                       const ChosenDisplay& display, int views) {
    // incomplete sets of outputs and the report are made again
    Outputs outputs(commandLine.has("y") || plan.skipExisting);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    for (const char* option : {"n", "net-profile", "camera"}) {
        if (const auto file = commandLine.value(option)) outputs.addInput(*file);
    }
    for (PhotoItem& item : plan.items) {
        outputs.addInput(item.photo);
        if (!item.depth.empty()) outputs.addInput(item.depth);
        if (plan.batch) {
            for (const fs::path& file : {item.native, item.quilt, item.savedDepth, item.rgbd,
                                         item.photoWithDepth, item.video}) {
                if (!file.empty()) outputs.addDirectory(file.parent_path());
            }
        }
        for (const fs::path& file : {item.native, item.quilt, item.savedDepth, item.rgbd}) {
            if (!file.empty()) requirePictureName(file, file != item.savedDepth);
        }
        if (!item.photoWithDepth.empty() && !isJpegName(item.photoWithDepth)) {
            throw UsageError("--save-photo-with-depth " + item.photoWithDepth.string() +
                             ": is not the name of a JPEG, expected FILE.jpg");
        }
        if (!item.video.empty()) requireVideoName(item.video);
        if (!item.views.empty()) outputs.addDirectory(item.views);
        const std::vector<fs::path> files = outputsOf(item, views);
        for (const fs::path& file : files) {
            if (file == item.native && !plan.batch) {
                outputs.addNative(file);
            } else {
                outputs.addOutput(file);
            }
        }
        item.isMade =
            plan.skipExisting && std::all_of(files.begin(), files.end(), isFileWithContents);
    }
    if (!plan.report.empty()) outputs.addOutput(plan.report);
    outputs.check();
    return outputs;
}

} // namespace altiro3D::tools
