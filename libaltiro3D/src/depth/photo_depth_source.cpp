// Depth in a photo's file or beside it, and another source for all other photos.

#include "altiro3D/depth_source.hpp"
#include "altiro3D/embedded_depth.hpp"
#include "altiro3D/image_io.hpp"

#include <future>
#include <opencv2/core/utility.hpp>
#include <utility>

namespace altiro3D {

namespace {

namespace fs = std::filesystem;

// Raw numbers, near = bright, and what they are.
struct Found {
    cv::Mat raw;
    std::string description;
    Notes notes;
};

Found findDepth(const fs::path& photo) {
    Found found;
    const fs::path beside = findDepthBeside(photo);
    if (!beside.empty()) {
        found.raw = readDepthSamples(beside, &found.notes);
        for (Note& note : found.notes)
            note.text = beside.string() + ": " + note.text;
        found.description = "depth image beside the photo (" + beside.string() + ")";
        return found;
    }
    if (const auto depth = readEmbeddedDepth(photo, &found.notes)) {
        found.raw = depth->depth;
        found.description = "depth in the photo's file (" + depth->text() + ")";
    }
    for (Note& note : found.notes)
        note.text = photo.string() + ": " + note.text;
    return found;
}

class PhotoDepthSource : public DepthSource {
  public:
    PhotoDepthSource(std::unique_ptr<DepthSource> otherwise, const PhotoDepthOptions& options)
        : otherwise_(std::move(otherwise)), options_(options) {}

    std::string description() const override {
        return found_.description.empty() ? otherwise_->description() : found_.description;
    }
    DepthKind kind() const override {
        return found_.description.empty() ? otherwise_->kind() : DepthKind::NearWhite;
    }
    const DepthNetwork* network() const override { return otherwise_->network(); }

    cv::Mat readImage(const fs::path& file, Notes* notes) override {
        found_ = {};
        // each decoder is one thread's work
        std::launch when = std::launch::deferred;
        if (cv::getNumThreads() > 1) when |= std::launch::async;
        std::future<Found> depth =
            std::async(when, [&] { return options_.useDepth ? findDepth(file) : Found(); });
        cv::Mat photo = readPhotoOf(file, notes); // of two that are broken it is named
        found_ = depth.get();
        if (notes != nullptr) notes->insert(notes->end(), found_.notes.begin(), found_.notes.end());
        return photo;
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        if (found_.raw.empty()) return otherwise_->read(image, photo, raw);
        raw = std::exchange(found_.raw, cv::Mat());
        photo = image;
    }
    void readScene(const cv::Mat& image, double flatDepth, Scene& scene) override {
        if (found_.raw.empty()) return otherwise_->readScene(image, flatDepth, scene);
        DepthSource::readScene(image, flatDepth, scene);
    }

  private:
    cv::Mat readPhotoOf(const fs::path& file, Notes* notes) {
        if (options_.unblurred) {
            Notes own;
            cv::Mat original = readUnblurredPhoto(file, &own);
            if (notes != nullptr) {
                for (const Note& note : own)
                    notes->push_back({note.code, file.string() + ": " + note.text});
            }
            if (!original.empty()) return original;
        }
        return otherwise_->readImage(file, notes);
    }

    std::unique_ptr<DepthSource> otherwise_;
    PhotoDepthOptions options_;
    Found found_; // by the last readImage()
};

} // namespace

std::unique_ptr<DepthSource> depthInPhoto(std::unique_ptr<DepthSource> otherwise,
                                          const PhotoDepthOptions& options) {
    if (!otherwise) {
        throw Error(ErrorCode::InvalidArgument, "otherwise", "is null, expected a source");
    }
    return std::make_unique<PhotoDepthSource>(std::move(otherwise), options);
}

} // namespace altiro3D
