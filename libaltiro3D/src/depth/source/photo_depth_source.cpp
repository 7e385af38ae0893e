#include "altiro3D/depth_source.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "depth/source/photo_depth.hpp"
#include "image/depth_parts.hpp"
#include "image/exr_file.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <functional>
#include <future>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D {

namespace {

namespace fs = std::filesystem;

// Depth without its photo, and remarks on it.
struct Found : PhotoDepth {
    Notes notes;
};

// A damaged depth image beside the photo, which the user did not name, is reported and left out.
Found findBeside(const fs::path& photo) {
    Found found;
    const fs::path beside = findDepthBeside(photo);
    if (beside.empty()) return found;
    try {
        const PhotoFile file(beside);
        found.rawDepth = readDepthSamples(file, &found.notes);
        if (!exrDistanceOf(file).empty()) found.kind = DepthKind::Metric;
        putNameBefore(found.notes, beside);
        found.separateFile = beside;
        found.origin = DepthOrigin::Given;
        found.text = "depth image beside the photo (" + beside.string() + ")";
    } catch (const Error& error) {
        if (error.code() == ErrorCode::OutOfMemory) throw;
        found.notes = {{NoteCode::LeftOut, std::string(error.what()) + "; it is not used"}};
    }
    return found;
}

// @param before remarks about what was looked at before
Found findInFile(const PhotoFile& photo, const Notes& before) {
    Found found;
    if (const auto depth = readEmbeddedDepth(photo, &found.notes)) {
        found.rawDepth = depth->depth;
        found.origin = DepthOrigin::Given;
        found.text = "depth in the photo's file (" + depth->text() + ")";
    }
    putNameBefore(found.notes, photo.path());
    found.notes.insert(found.notes.begin(), before.begin(), before.end());
    return found;
}

Found findDepth(const PhotoFile& photo) {
    Found found = findBeside(photo.path());
    return found.rawDepth.empty() ? findInFile(photo, found.notes) : found;
}

// If a depth image beside the photo does not fit it, takes the depth in the photo's file instead.
void replaceUnfit(Found& found, const PhotoFile& photo, cv::Size size) {
    if (found.separateFile.empty()) return;
    const std::string reason = reasonAgainstDepth(found.rawDepth, size);
    if (reason.empty()) return;
    found.notes.push_back(
        {NoteCode::LeftOut, found.separateFile.string() + ": is not used as depth: " + reason});
    found = findInFile(photo, found.notes);
}

// Without a reliable match there is no depth, and a remark says why.
Found matchPair(const StereoPair& pair, const PhotoFile& photo) {
    Found found;
    static_cast<PhotoDepth&>(found) = matchedDepth(pair, found.notes);
    putNameBefore(found.notes, photo.path());
    return found;
}

// Each decoder is one thread's work.
std::launch besideOthers() {
    return cv::getNumThreads() > 1 ? std::launch::async | std::launch::deferred
                                   : std::launch::deferred;
}

// @param photo is passed on with the depth found; without depth, `fallback` estimates it later
PhotoDepth withPhoto(Found found, const cv::Mat& photo, const DepthSource& fallback, Notes* notes) {
    addNotes(notes, found.notes);
    if (found.rawDepth.empty()) found.text = fallback.description();
    found.photo = photo;
    return static_cast<PhotoDepth&&>(found);
}

// @param fallback decodes the file by its readPhoto(), and estimates nothing yet
cv::Mat readPhotoOf(const PhotoFile& file, bool unblurred, DepthSource& fallback, Notes* notes) {
    if (unblurred) {
        cv::Mat original = withNamedNotes(
            file.path(), notes, [&](Notes* own) { return readUnblurredPhoto(file, own); });
        if (!original.empty()) {
            addNote(notes, NoteCode::Chosen,
                    file.path().string() + ": the sharp original in the file is used");
            return original;
        }
    }
    return fallback.readPhoto(file, notes).photo; // for a network, altiro3D::readPhoto()
}

PhotoDepth readStored(const PhotoFile& file, const PhotoDepthOptions& options,
                      DepthSource& fallback, Notes* notes) {
    static_cast<void>(file.bytes()); // reads a pipe once, also for its depth
    std::future<Found> depth =
        std::async(besideOthers(), [&] { return options.useDepth ? findDepth(file) : Found(); });
    const std::optional<StereoPair> pair = withNamedNotes(file.path(), notes, [&](Notes* own) {
        return options.useDepth ? readStereoPair(file, own) : std::nullopt;
    });
    // before depth.get(): if both are damaged, the error names the photo
    const cv::Mat photo = pair ? pair->left : readPhotoOf(file, options.unblurred, fallback, notes);
    Found found = depth.get();
    replaceUnfit(found, file, photo.size());
    if (!options.useDepth || !found.rawDepth.empty())
        return withPhoto(found, photo, fallback, notes);
    addNotes(notes, found.notes);
    if (pair) return withPhoto(matchPair(*pair, file), photo, fallback, notes);
    if (!options.namedHalves) return withPhoto({}, photo, fallback, notes);
    const std::optional<PhotoDepth> halves = withNamedNotes(
        file.path(), notes, [&](Notes* own) { return readNamedHalves(file, photo, own); });
    return halves ? *halves : withPhoto({}, photo, fallback, notes);
}

StereoPair readPair(const PhotoFile& file, const StereoInput& input, DepthSource& fallback,
                    Notes* notes) {
    if (input.right.empty()) {
        const cv::Mat picture = fallback.readPhoto(file, notes).photo;
        try {
            return withNamedNotes(file.path(), notes, [&](Notes* own) {
                return splitStereoFile(picture, input.layout, input.halves, file, own);
            });
        } catch (const Error& error) {
            throw Error(error.code(), file.path().string(), error.what());
        }
    }
    Notes rightNotes;
    std::future<cv::Mat> right =
        std::async(besideOthers(), [&] { return readPhoto(input.right, &rightNotes); });
    StereoPair pair;
    pair.left = fallback.readPhoto(file, notes).photo;
    pair.right = right.get();
    pair.origin = "two files";
    putNameBefore(rightNotes, input.right);
    addNotes(notes, rightNotes);
    leaveOutFrame(pair, notes);
    return pair;
}

PhotoDepth readEyesOf(const PhotoFile& file, const StereoInput& input, DepthSource& fallback,
                      Notes* notes) {
    const StereoPair pair = readPair(file, input, fallback, notes);
    try {
        Found found = matchPair(pair, file);
        if (found.rawDepth.empty() && input.right.empty() && !found.notes.empty())
            found.notes.front().text += "; if the file does not hold both eyes, all of it is "
                                        "shown without --stereo";
        return withPhoto(std::move(found), pair.left, fallback, notes);
    } catch (const Error& error) {
        if (input.right.empty() || error.code() != ErrorCode::Mismatch) throw;
        throw Error(error.code(), input.right.string(), error.what());
    }
}

// Reads photos by a function that looks for depth; all else is left to another source.
class PhotoDepthSource : public DepthSource {
  public:
    using Read = std::function<PhotoDepth(const PhotoFile&, DepthSource& fallback, Notes*)>;
    PhotoDepthSource(std::shared_ptr<DepthSource> fallback, Read read)
        : fallback_(std::move(fallback)), read_(std::move(read)) {
        check(fallback_ != nullptr, "fallback", "is null, expected a source");
    }

    std::string description() const override { return fallback_->description(); }
    DepthEdges edges() const override { return fallback_->edges(); }
    DepthKind kind() const override { return fallback_->kind(); }
    const DepthNetwork* network() const override { return fallback_->network(); }
    void load() override { fallback_->load(); }
    PhotoDepth readPhoto(const PhotoFile& file, Notes* notes) override try {
        return read_(file, *fallback_, notes);
    } catch (const cv::Exception& exception) {
        leaveAsOurs(exception);
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        fallback_->read(image, photo, raw);
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        fallback_->readFrame(image, photo, raw);
    }

  private:
    std::shared_ptr<DepthSource> fallback_;
    Read read_;
};

std::optional<PhotoDepth> readRgbd(const PhotoFile& file, const SceneName& name,
                                   const cv::Mat& picture, Notes* notes) {
    constexpr const char* kSides[] = {"right", "left", "upper", "lower"};
    const std::optional<DepthSide> side = findDepthHalf(picture, name.isStacked);
    if (!side) {
        addReadAsPhoto(notes, name, "says that it holds depth, but no half of it is clearly depth");
        return std::nullopt;
    }
    PhotoDepth halves;
    halves.origin = DepthOrigin::Given;
    splitRgbd(readRgbdImage(file, *side), {*side, name.halves}, halves.photo, halves.rawDepth,
              notes);
    halves.text = std::string("depth half of the picture (") + entryOf(kSides, *side) +
                  ", by its name, " + name.tag + ")";
    return halves;
}

} // namespace

std::unique_ptr<DepthSource> storedDepthOr(std::shared_ptr<DepthSource> fallback,
                                           const PhotoDepthOptions& options) {
    return std::make_unique<PhotoDepthSource>(
        std::move(fallback), [options](const PhotoFile& file, DepthSource& other, Notes* notes) {
            return readStored(file, options, other, notes);
        });
}

std::unique_ptr<DepthSource> depthFromStereo(StereoInput input,
                                             std::shared_ptr<DepthSource> fallback) {
    return std::make_unique<PhotoDepthSource>(
        std::move(fallback),
        [input = std::move(input)](const PhotoFile& file, DepthSource& other, Notes* notes) {
            return readEyesOf(file, input, other, notes);
        });
}

std::optional<PhotoDepth> readNamedHalves(const PhotoFile& file, const cv::Mat& picture,
                                          Notes* notes) try {
    const std::optional<SceneName> name = parseSceneName(file.path());
    if (!name || std::min(picture.cols, picture.rows) < 2) return std::nullopt;
    refuseVrName(file.path());
    try {
        return name->contents == SceneName::Contents::Eyes
                   ? matchedDepth(*name, picture, file.path(), file.look(), notes)
                   : readRgbd(file, *name, picture, notes);
    } catch (const Error& error) {
        if (std::string(error.what()).find(file.path().string()) == 0) throw;
        throw Error(error.code(), file.path().string(), error.what());
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
