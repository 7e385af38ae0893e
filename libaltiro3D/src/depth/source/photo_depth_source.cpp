// Depth that comes with a photo: beside it, in its file, from the pictures of both eyes, or in a
// half of it; and another source for all other photos.

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "image/depth_parts.hpp"

#include <future>
#include <opencv2/core/utility.hpp>
#include <utility>

namespace altiro3D {

namespace {

namespace fs = std::filesystem;

// Raw numbers, near = bright, and what they are.
struct Found {
    cv::Mat raw;
    HiddenLayer hidden;      // of a stereo pair, with disparities as depth
    std::string description; // empty: nothing was found
    DepthOrigin origin = DepthOrigin::Given;
    fs::path beside; // the file, if it has one of its own
    Notes notes;
};

void putNameBefore(Notes& notes, const fs::path& file) {
    for (Note& note : notes)
        note.text = file.string() + ": " + note.text;
}

// A damaged depth image beside the photo, which nobody named, is reported and left out.
Found findBeside(const fs::path& photo) {
    Found found;
    const fs::path beside = findDepthBeside(photo);
    if (beside.empty()) return found;
    try {
        found.raw = readDepthSamples(beside, &found.notes);
        putNameBefore(found.notes, beside);
        found.beside = beside;
        found.description = "depth image beside the photo (" + beside.string() + ")";
    } catch (const Error& error) {
        if (error.code() == ErrorCode::OutOfMemory) throw;
        found.notes = {{NoteCode::LeftOut, std::string(error.what()) + "; it is not used"}};
    }
    return found;
}

// @param before remarks about what was looked at before
Found findInFile(const fs::path& photo, const Notes& before) {
    Found found;
    if (const auto depth = readEmbeddedDepth(photo, &found.notes)) {
        found.raw = depth->depth;
        found.description = "depth in the photo's file (" + depth->text() + ")";
    }
    putNameBefore(found.notes, photo);
    found.notes.insert(found.notes.begin(), before.begin(), before.end());
    return found;
}

Found findDepth(const fs::path& photo) {
    Found found = findBeside(photo);
    return found.raw.empty() ? findInFile(photo, found.notes) : found;
}

// The same, if a depth image beside the photo does not fit it.
void replaceUnfit(Found& found, const fs::path& photo, cv::Size size) {
    if (found.beside.empty()) return;
    const std::string reason = reasonAgainstDepth(found.raw, size);
    if (reason.empty()) return;
    found.notes.push_back(
        {NoteCode::LeftOut, found.beside.string() + ": is not used as depth: " + reason});
    found = findInFile(photo, found.notes);
}

// Without a reliable match there is no depth, and a remark says why.
Found matchPair(const StereoPair& pair, const fs::path& photo) {
    Found found;
    found.origin = DepthOrigin::Matched;
    const StereoMatch match = matchStereo(pair.left, pair.right, found.raw, &found.hidden);
    found.notes = match.remarks(pair.origin);
    if (match.isReliable) {
        found.description = "stereo pair (" + pair.origin + "), depth by matching; " + match.text();
    } else {
        found.raw.release();
    }
    putNameBefore(found.notes, photo);
    return found;
}

// What readImage() found for the next read(); if nothing, another source.
class FoundDepthSource : public DepthSource {
  public:
    explicit FoundDepthSource(std::shared_ptr<DepthSource> fallback)
        : fallback_(std::move(fallback)) {}

    std::string description() const override {
        return found_.description.empty() ? fallback_->description() : found_.description;
    }
    DepthOrigin origin() const override {
        return found_.description.empty() ? fallback_->origin() : found_.origin;
    }
    fs::path separateFile() const override { return found_.beside; }
    DepthEdges edges() const override {
        return found_.description.empty() ? fallback_->edges() : DepthSource::edges();
    }
    DepthKind kind() const override {
        return found_.description.empty() ? fallback_->kind() : DepthKind::NearWhite;
    }
    const DepthNetwork* network() const override { return fallback_->network(); }
    void load() override { fallback_->load(); }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        if (found_.raw.empty()) return fallback_->read(image, photo, raw);
        found_.raw.copyTo(raw); // may be read again
        photo = image;
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        if (found_.raw.empty()) return fallback_->readFrame(image, photo, raw);
        read(image, photo, raw);
    }
    void readScene(const cv::Mat& image, double flatDepth, Scene& scene) override {
        if (found_.raw.empty()) return fallback_->readScene(image, flatDepth, scene);
        DepthSource::readScene(image, flatDepth, scene);
        if (found_.hidden.photo.empty()) return;
        scene.hidden = {found_.hidden.photo, found_.hidden.depth};
        scaleHiddenDepth(found_.raw, scene.depth, scene.hidden);
    }

  protected:
    DepthSource& fallback() { return *fallback_; }
    void keep(Found found, Notes* notes) {
        found_ = std::move(found);
        if (notes != nullptr) notes->insert(notes->end(), found_.notes.begin(), found_.notes.end());
    }

  private:
    std::shared_ptr<DepthSource> fallback_;
    Found found_;
};

class PhotoDepthSource : public FoundDepthSource {
  public:
    PhotoDepthSource(std::shared_ptr<DepthSource> fallback, const PhotoDepthOptions& options)
        : FoundDepthSource(std::move(fallback)), options_(options) {}

    cv::Mat readImage(const fs::path& file, Notes* notes) override {
        keep({}, nullptr);
        // each decoder is one thread's work
        std::launch when = std::launch::deferred;
        if (cv::getNumThreads() > 1) when |= std::launch::async;
        std::future<Found> depth =
            std::async(when, [&] { return options_.useDepth ? findDepth(file) : Found(); });
        cv::Mat photo;
        Notes pairNotes;
        std::optional<StereoPair> pair;
        if (options_.useDepth) pair = readStereoPair(file, &pairNotes);
        putNameBefore(pairNotes, file);
        if (notes != nullptr) notes->insert(notes->end(), pairNotes.begin(), pairNotes.end());
        photo = pair ? pair->left : readPhotoOf(file, notes); // of two that are broken it is named
        Found found = depth.get();
        replaceUnfit(found, file, photo.size());
        if (pair && found.raw.empty()) {
            Found matched = matchPair(*pair, file);
            matched.notes.insert(matched.notes.begin(), found.notes.begin(), found.notes.end());
            found = std::move(matched);
        } else if (options_.useDepth && found.raw.empty()) {
            takeNamedHalves(file, photo, found);
        }
        keep(std::move(found), notes);
        return photo;
    }

  private:
    static void takeNamedHalves(const fs::path& file, cv::Mat& photo, Found& found) {
        Notes own;
        std::optional<NamedHalves> halves = readNamedHalves(file, photo, &own);
        putNameBefore(own, file);
        found.notes.insert(found.notes.end(), own.begin(), own.end());
        if (!halves) return;
        photo = halves->photo;
        found.raw = halves->rawDepth;
        found.hidden = std::move(halves->hidden);
        found.description = halves->text;
        found.origin = halves->origin;
    }
    cv::Mat readPhotoOf(const fs::path& file, Notes* notes) {
        if (options_.unblurred) {
            Notes own;
            cv::Mat original = readUnblurredPhoto(file, &own);
            putNameBefore(own, file);
            if (notes != nullptr) notes->insert(notes->end(), own.begin(), own.end());
            if (!original.empty()) {
                if (notes != nullptr)
                    notes->push_back({NoteCode::Chosen, file.string() +
                                                            ": the sharp original in the file is "
                                                            "used"});
                return original;
            }
        }
        return fallback().readImage(file, notes);
    }

    PhotoDepthOptions options_;
};

class StereoSource : public FoundDepthSource {
  public:
    StereoSource(StereoInput input, std::shared_ptr<DepthSource> fallback)
        : FoundDepthSource(std::move(fallback)), input_(std::move(input)) {}

    cv::Mat readImage(const fs::path& file, Notes* notes) override {
        keep({}, nullptr);
        const StereoPair pair = readPair(file, notes);
        try {
            Found found = matchPair(pair, file);
            if (found.raw.empty() && input_.right.empty() && !found.notes.empty())
                found.notes.front().text += "; if the file does not hold both eyes, all of it is "
                                            "shown without --stereo";
            keep(std::move(found), notes);
        } catch (const Error& error) {
            if (input_.right.empty() || error.code() != ErrorCode::Mismatch) throw;
            throw Error(error.code(), input_.right.string(), error.what());
        }
        return pair.left;
    }

  private:
    StereoPair readPair(const fs::path& file, Notes* notes) {
        if (input_.right.empty()) {
            const cv::Mat picture = fallback().readImage(file, notes);
            try {
                return splitStereoPair(picture, input_.layout, halvesOf(file, input_.halves));
            } catch (const Error& error) {
                throw Error(error.code(), file.string(), error.what());
            }
        }
        Notes rightNotes;
        std::launch when = std::launch::deferred;
        if (cv::getNumThreads() > 1) when |= std::launch::async;
        std::future<cv::Mat> right =
            std::async(when, [&] { return readPhoto(input_.right, &rightNotes); });
        StereoPair pair;
        pair.left = fallback().readImage(file, notes);
        pair.right = right.get();
        pair.origin = "two files";
        putNameBefore(rightNotes, input_.right);
        if (notes != nullptr) notes->insert(notes->end(), rightNotes.begin(), rightNotes.end());
        return pair;
    }

    StereoInput input_;
};

} // namespace

std::unique_ptr<DepthSource> storedDepthOr(std::shared_ptr<DepthSource> fallback,
                                           const PhotoDepthOptions& options) {
    if (!fallback) {
        throw Error(ErrorCode::InvalidArgument, "fallback", "is null, expected a source");
    }
    return std::make_unique<PhotoDepthSource>(std::move(fallback), options);
}

std::unique_ptr<DepthSource> depthFromStereo(StereoInput input,
                                             std::shared_ptr<DepthSource> fallback) {
    if (!fallback) {
        throw Error(ErrorCode::InvalidArgument, "fallback", "is null, expected a source");
    }
    return std::make_unique<StereoSource>(std::move(input), std::move(fallback));
}

} // namespace altiro3D
