#include "viewer/model/document.hpp"

#include "altiro3D/altiro3D.hpp"
#include "cli/folders.hpp"
#include "cli/network_trust.hpp"
#include "cli/quilt_options.hpp"
#include "cli/run_tool.hpp"
#include "cli/views_folder.hpp"
#include "video/video_run.hpp"

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>
#include <set>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

cv::Mat eightBit(const cv::Mat& picture) {
    if (picture.depth() == CV_8U) return picture;
    cv::Mat result;
    picture.convertTo(result, CV_8U, picture.depth() == CV_16U ? 1 / 257.0 : 255.0);
    return result;
}

// The reading that a name such as a_rgbd.mp4 states.
std::optional<Reading> namedDepthHalf(const fs::path& file) {
    const auto name = parseSceneName(file);
    if (!name || name->contents != SceneName::Contents::Rgbd) return std::nullopt;
    return name->isStacked ? Reading::RgbdBottom : Reading::RgbdRight;
}

// What a picture, its name and its size suggest.
// @param found what was found in it; is set if the picture was searched
Reading guess(const fs::path& file, const cv::Mat& picture, const Display& display,
              std::optional<FoundQuilt>& found) {
    const cv::Size size = picture.size();
    const std::string stem = lowerCase(file.stem().string());
    if (size == display.panelSize() && isMarkedNative(file)) return Reading::Native;
    if (parseQuiltName(file)) return Reading::Quilt;
    if (const auto named = namedDepthHalf(file); named && isVideoName(file))
        return *named;                               // single frames may be dark
    if (parseSceneName(file)) return Reading::Photo; // addPhotoDepth() examines its halves
    static const std::set<std::string> kLossy = {".jpg", ".jpeg", ".jpe", ".jfif"};
    const bool lossy = kLossy.count(lowerExtension(file)) > 0;
    if (size == display.panelSize() && (!lossy || stem.find("native") != std::string::npos))
        return Reading::Native;
    found = findQuiltLayout(eightBit(picture));
    QuiltRequest request;
    request.quiltSize = size;
    return tools::isQuiltPicture(*found, size, usualQuilt(display, request)) ? Reading::Quilt
                                                                             : Reading::Photo;
}

// The side or layout of a reading from `first` to `last`, which are in the order of `Half`.
template <typename Half>
std::optional<Half> halfOf(Reading reading, Reading first, Reading last) {
    if (reading < first || reading > last) return std::nullopt;
    return static_cast<Half>(static_cast<int>(reading) - static_cast<int>(first));
}

std::optional<DepthSide> sideOf(Reading reading) {
    return halfOf<DepthSide>(reading, Reading::RgbdRight, Reading::RgbdBottom);
}

std::optional<StereoLayout> eyesOf(Reading reading) {
    return halfOf<StereoLayout>(reading, Reading::EyesLeftRight, Reading::EyesTopBottom);
}

Document documentOfViews(const Source& source, const Display& display) {
    Document document;
    const std::vector<fs::path> files = tools::listViews(source.file, &document.notes);
    document.source = source;
    document.kind = Kind::Quilt;
    document.layout = display.quilt;
    tools::Messages messages("altiro3Dview", false);
    document.picture = tools::quiltOfViews(files, document.layout, display.aspect(), FitMode::Cover,
                                           messages, [](const fs::path&) {})
                           .quilt;
    for (const std::string& warning : messages.warnings())
        document.notes.push_back({NoteCode::Doubtful, warning});
    return document;
}

Document documentOfSlide(const Source& source, const Display& display) {
    Document document;
    document.source = source;
    document.kind = Kind::Quilt;
    document.layout = display.quilt;
    std::vector<fs::path> files;
    CameraSlide slide(tools::slideOf({source.file}, files, &document.notes),
                      tools::slideOptionsFor(document.layout, display.aspect(), FitMode::Cover),
                      source.file.string());
    document.picture =
        tools::quiltOfSlide(slide, document.layout, display.aspect(), FitMode::Cover);
    const Notes notes = slide.notes();
    document.notes.insert(document.notes.end(), notes.begin(), notes.end());
    for (const std::string& line : slide.report().lines())
        document.notes.push_back({NoteCode::Chosen, line});
    return document;
}

// The views of a scene of splats as splat2native makes them.
Document documentOfSplats(const Source& source, const Display& display) {
    Document document;
    document.source = source;
    document.kind = Kind::Quilt;
    document.splats =
        std::make_shared<SplatScene>(readSplats(source.file, SplatAxes::Auto, &document.notes));
    SplatSight sight;
    sight.layout = display.quilt;
    document.notes.push_back(
        {NoteCode::Chosen,
         "splats; camera: " +
             chooseSplatCamera(*document.splats, display.quilt.tileSize, display.aspect()).how});
    return withSight(document, display, sight);
}

// The left picture is shown; pairs that do not match have no depth.
void addPair(Document& document, const StereoPair& pair) {
    document.picture = pair.left;
    document.origin = DepthOrigin::Matched;
    const StereoMatch match =
        matchStereo(pair.left, pair.right, document.rawDepth, &document.hidden);
    document.notes = match.remarks(pair.origin);
    if (match.isReliable) {
        document.depthOrigin = "stereo pair (" + pair.origin + "), " + match.text();
    } else {
        document.rawDepth.release();
    }
}

// Whether a video is searched for both eyes' pictures.
bool mayHoldEyes(const Source& video) {
    return video.reading == Reading::Automatic && tools::isFile(video.file) &&
           !depthSideOf(video) && !parseQuiltName(video.file);
}

// Both eyes' pictures in those of a video, by its reading or by what is found.
FoundEyes videoEyes(const Source& source) {
    FoundEyes found;
    const auto layout = eyesOf(source.reading);
    if (!layout && !mayHoldEyes(source)) return found;
    const VideoReaderOptions reading = readingOf(source);
    const VideoFacts facts = VideoReader(source.file, reading).facts();
    if (!layout) return findEyes(source.file, facts, reading);
    found.eyes = StereoVideo{*layout, halvesOf(source.file)};
    found.eyes->halves = halvesAsShown(*found.eyes, facts);
    found.evidence = "you have chosen it";
    return found;
}

// Uses the depth stream of a video as video2native does.
void addDepthTrack(Document& document) {
    const Source& source = document.source;
    if (document.kind != Kind::Scene || !mayHoldEyes(source)) return;
    try {
        const VideoReaderOptions reading = readingOf(source);
        const VideoFacts facts = VideoReader(source.file, reading).facts();
        const auto track = tools::findDepthTrack(source.file, reading, facts);
        if (track && !track->fits)
            document.notes.push_back(
                {NoteCode::LeftOut,
                 std::string("the depth in the file is not used, ") + tools::kMisfitText});
        if (!track || !track->fits) return;
        GivenVideoDepth given;
        given.source = source.file;
        given.kind = track->kind();
        auto depth = std::make_shared<GivenDepthReader>(given, facts);
        depth->next(document.picture, 0, document.rawDepth);
        document.depthTrack = std::move(depth);
        document.depthOrigin = "depth in the video, " + track->text();
    } catch (const Error& error) {
        document.notes.push_back(
            {NoteCode::LeftOut, "the depth in the file is not used: " + tools::sentenceOf(error)});
    }
}

// Adds the depth of the first picture of a video, which is shown until it plays.
void addFirstDepth(Document& document, const std::string& evidence) {
    document.depthOrigin = "both eyes, as " + evidence;
    const StereoMatch match = matchStereo(document.picture, document.right, document.rawDepth);
    document.right.release();
    if (!match.areEyes() || match.isFlat) document.rawDepth.release();
}

// Says so if near and far of given depth look exchanged.
void checkDirection(const Document& document, Notes& notes) {
    if (document.kind != Kind::Scene || document.rawDepth.empty() ||
        document.origin != DepthOrigin::Given)
        return;
    cv::Mat depth;
    normalizeDepth(document.rawDepth, depth);
    if (!looksInverted(depth, [&] { return tools::trustedEstimate(document.picture); })) return;
    const Source& source = document.source;
    const fs::path& file = source.depth.empty() ? source.file : source.depth;
    notes.push_back({NoteCode::Inverted, file.string() +
                                             ": near and far look exchanged: its depth seems to be "
                                             "white where things are far, expected near is white"});
}

// Gives the photo that is read already, for depth that comes with it.
class ReadPhotoSource : public DepthSource {
  public:
    explicit ReadPhotoSource(const cv::Mat& photo) { found_.photo = photo; }

    std::string description() const override { return {}; }
    DepthKind kind() const override { return DepthKind::NearWhite; }
    PhotoDepth readPhoto(const PhotoFile& /*file*/, Notes* notes) override {
        const std::string mixed = mixedEyes(found_.photo);
        if (!mixed.empty() && notes != nullptr) notes->push_back({NoteCode::Doubtful, mixed});
        return found_;
    }
    void read(const cv::Mat& /*image*/, cv::Mat& /*photo*/, cv::Mat& /*raw*/) override {}

  private:
    PhotoDepth found_;
};

void addPhotoDepth(Document& document, const PhotoFile& file, Notes& notes) {
    PhotoDepthOptions options;
    options.namedHalves = document.source.reading == Reading::Automatic;
    Notes own;
    PhotoDepth found = storedDepthOr(std::make_shared<ReadPhotoSource>(document.picture), options)
                           ->readPhoto(file, &own);
    if (found.origin == DepthOrigin::Matched) { // the second picture is used
        notes.erase(std::remove_if(notes.begin(), notes.end(),
                                   [](const Note& note) { return note.code == NoteCode::LeftOut; }),
                    notes.end());
    }
    notes.insert(notes.end(), own.begin(), own.end());
    document.picture = found.photo;
    document.rawDepth = found.rawDepth;
    document.hidden = std::move(found.hidden);
    document.origin = found.origin;
    document.depthOrigin = found.text;
}

// Leaves out photos whose splats are there as well: a.jpg and a.ply, which SHARP made of it.
void leaveOutPhotosOfSplats(std::vector<Source>& sources) {
    std::set<fs::path> splats; // without extension
    for (const Source& source : sources)
        if (isSplatFileName(source.file))
            splats.insert(source.file.parent_path() / source.file.stem());
    const auto hasSplats = [&](const Source& source) {
        return !isSplatFileName(source.file) && !isVideoName(source.file) &&
               splats.count(source.file.parent_path() / source.file.stem()) > 0;
    };
    sources.erase(std::remove_if(sources.begin(), sources.end(), hasSplats), sources.end());
}

// Whether the files of a folder are views of one scene.
bool areViews(const std::vector<Source>& files) {
    std::vector<fs::path> pictures;
    for (const Source& source : files) {
        const fs::path& file = source.file;
        if (!source.depth.empty() || isVideoName(file) || parseQuiltName(file) ||
            isMarkedNative(file))
            return false;
        pictures.push_back(file);
    }
    return tools::reasonAgainstViews(pictures).empty();
}

} // namespace

void Document::readDepth(cv::Mat& map) const {
    if (depthTrack) return rawDepth.copyTo(map);
    if (!video || eyes) return normalizeDepth(rawDepth, map);
    rawDepth.convertTo(map, CV_8U); // one range for all frames, as in video2native
    map.convertTo(map, CV_32F, 1 / 255.0);
}

std::string Document::facts() const {
    switch (kind) {
    case Kind::Quilt:
        if (splats) return "Splats, " + std::to_string(splats->splats.size());
        return (video ? "Video of quilts, " : "Quilt, ") + layout.text() +
               (certainty ? ", " + fixed(100 * *certainty, 0) + " % sure" : "");
    case Kind::Native:
        return (video ? "Native video, " : "Native, ") + sizeText(picture.size());
    case Kind::Scene:
        break;
    }
    return (video ? "Video, " : "Photo, ") + sizeText(picture.size()) +
           (!depthOrigin.empty() ? "; " + depthOrigin
            : rawDepth.empty()   ? ""
                                 : ", with depth");
}

Document withSight(const Document& document, const Display& display, const SplatSight& sight) {
    Document seen = document;
    seen.layout = sight.layout;
    if (sight.isDraft)
        seen.layout.tileSize = {std::max(1, sight.layout.tileSize.width / 2),
                                std::max(1, sight.layout.tileSize.height / 2)};
    SplatCameraOptions options;
    options.yaw = 360 * (sight.framing.centre.x - 0.5);
    options.tilt = 180 * (sight.framing.centre.y - 0.5);
    SplatCamera camera =
        chooseSplatCamera(*seen.splats, seen.layout.tileSize, display.aspect(), options).camera;
    camera.intrinsics.fx *= sight.framing.zoom;
    camera.intrinsics.fy *= sight.framing.zoom;
    const SplatRenderer renderer(*seen.splats, camera, sight.isDraft);
    const SplatView middle = renderer.render();
    seen.placement = placeSplats(middle, camera, seen.layout, sight.focus, sight.strengthPercent);
    seen.depth = altiro3D::depthOf(middle, *seen.placement);
    if (sight.isOneView) {
        seen.layout = {1, 1, seen.layout.tileSize, 1};
        seen.picture = middle.picture;
    } else {
        seen.picture.release(); // the document's own is kept
        renderQuilt(renderer, *seen.placement, seen.layout, seen.picture);
    }
    return seen;
}

void refusePipe(const fs::path& file) {
    std::error_code error;
    if (fs::is_fifo(file, error))
        throw Error(ErrorCode::Unsupported, file.string(),
                    "is a pipe, which can be read only once, expected a file");
}

bool isVideoName(const fs::path& file) {
    std::error_code error;
    if (fs::is_character_file(file, error)) return true;
    return tools::isVideoFileName(file);
}

VideoReaderOptions readingOf(const Source& video) {
    VideoReaderOptions options;
    options.bothEyes = eyesOf(video.reading).has_value() || mayHoldEyes(video);
    return options;
}

cv::Mat firstPicture(const fs::path& file, const VideoReaderOptions& reading) {
    if (isSplatFileName(file)) {
        const SplatScene scene = readSplats(file);
        const cv::Size size(240, 320); // of a thumbnail
        return SplatRenderer(scene, chooseSplatCamera(scene, size, 0.75).camera).render().picture;
    }
    if (!isVideoName(file)) return readPhoto(file);
    if (const auto first = VideoReader(file, reading).next()) return first->picture;
    throw Error(ErrorCode::BadFormat, file.string(), "holds no pictures, expected a video");
}

FolderFiles filesOfFolder(const fs::path& folder) {
    using tools::FileKind;
    tools::FolderSearch search;
    search.wanted = {FileKind::Photo,      FileKind::Quilt,      FileKind::Native, FileKind::Video,
                     FileKind::QuiltVideo, FileKind::DepthVideo, FileKind::Splats};
    const tools::FolderContents found = tools::searchFolder(folder, search);
    FolderFiles result;
    for (const tools::FolderFile& file : found.files)
        result.files.push_back({file.file, file.depth, Reading::Automatic});
    leaveOutPhotosOfSplats(result.files);
    if (result.files.empty())
        throw Error(ErrorCode::NotFound, folder.string(),
                    "holds no pictures and no videos, expected some");
    if (areViews(result.files)) {
        result.files = {{folder, {}, Reading::Automatic}};
    } else if (!found.leftOut.empty()) {
        result.notes.push_back({NoteCode::LeftOut, folder.string() + ": not opened: " +
                                                       tools::kindsText(found.leftOut)});
    }
    return result;
}

Document documentOf(const Source& source, const cv::Mat& picture, const Display& display,
                    const std::optional<StereoVideo>& eyes) {
    Document document;
    document.source = source;
    document.video = isVideoName(source.file);
    if (eyes) {
        const StereoPair pair = splitStereoPair(eightBit(picture), eyes->layout, eyes->halves);
        document.picture = pair.left;
        document.right = pair.right;
        document.eyes = eyes;
        document.origin = DepthOrigin::Matched;
        return document;
    }
    std::optional<FoundQuilt> found;
    const Reading reading = source.reading == Reading::Automatic
                                ? guess(source.file, picture, display, found)
                                : source.reading;
    if (const auto side = sideOf(reading)) {
        splitRgbd(picture, {*side, halvesOf(source.file)}, document.picture, document.rawDepth,
                  &document.notes);
        return document;
    }
    document.picture = eightBit(picture);
    if (const auto layout = eyesOf(reading)) {
        Notes notes;
        addPair(document, splitStereoFile(document.picture, *layout, StereoHalves::Automatic,
                                          source.file, &notes));
        document.notes.insert(document.notes.end(), notes.begin(), notes.end());
    } else if (reading == Reading::Quilt) {
        QuiltRequest request;
        request.name = parseQuiltName(source.file);
        request.quiltSize = picture.size();
        if (!request.name) {
            if (!found) found = findQuiltLayout(document.picture);
            if (found->verdict == QuiltVerdict::Quilt)
                request.found = QuiltGrid{found->layout.columns, found->layout.rows};
        }
        const ResolvedQuilt resolved =
            resolveQuilt(request, usualQuilt(display, request), display.aspect());
        document.kind = Kind::Quilt;
        document.layout = resolved.layout;
        if (request.found) document.certainty = found->confidence;
        document.notes = checkQuiltLayout(document.picture, document.layout);
        document.notes.insert(document.notes.end(), resolved.notes.begin(), resolved.notes.end());
        document.picture = fitQuilt(document.picture, document.layout);
        const QuiltShape shape(source.file, document.layout, display);
        if (shape.stretchesUnasked())
            document.notes.push_back({NoteCode::Doubtful, tools::stretchText(shape)});
        if (shape.fitsUnasked())
            document.notes.push_back({NoteCode::AsItIs,
                                      "the file name states another shape than the panel's: black "
                                      "bars keep it on the display"});
    } else if (reading == Reading::Native) {
        document.kind = Kind::Native;
    } else if (picture.size() != display.panelSize() && isMarkedNative(source.file)) {
        document.notes.push_back(
            {NoteCode::Doubtful, "the file says that it is a Native, but not of this display's " +
                                     sizeText(display.panelSize()) + "; it is taken as a photo"});
    }
    return document;
}

Document documentOfFrame(const Document& video, const cv::Mat& picture, const Display& display) {
    Source source = video.source;
    if (video.depthTrack) source.reading = Reading::Photo; // no search for a quilt in each
    Document document = documentOf(source, picture, display, video.eyes);
    document.source = video.source;
    document.depthOrigin = video.depthOrigin;
    document.depthTrack = video.depthTrack;
    return document;
}

std::optional<DepthSide> depthSideOf(const Source& video) {
    const bool isStated = video.reading != Reading::Automatic;
    return sideOf(isStated ? video.reading
                           : namedDepthHalf(video.file).value_or(Reading::Automatic));
}

Document readDocument(const Source& source, const Display& display) {
    refusePipe(source.file);
    refusePipe(source.depth);
    if (source.reading == Reading::Slide) return documentOfSlide(source, display);
    if (isSplatFileName(source.file)) return documentOfSplats(source, display);
    if (tools::isDirectory(source.file)) return documentOfViews(source, display);
    if (isVideoName(source.file)) {
        if (source.reading == Reading::Automatic) refuseVrName(source.file);
        const cv::Mat first = firstPicture(source.file, readingOf(source));
        Document document = documentOf(source, first, display);
        addDepthTrack(document);
        const FoundEyes found = document.depthTrack ? FoundEyes() : videoEyes(source);
        if (found.eyes) document = documentOf(source, first, display, found.eyes);
        if (document.kind == Kind::Scene)
            document.notes.insert(document.notes.end(), found.notes.begin(), found.notes.end());
        if (found.eyes) addFirstDepth(document, found.evidence);
        if (!source.depth.empty())
            document.notes.push_back(
                {NoteCode::LeftOut,
                 source.depth.string() + ": is not used, as depth images are for photos"});
        return document;
    }
    Notes notes;
    Document document;
    {
        const tools::QuietStandardError quiet; // decoders print messages
        const PhotoFile file(source.file);
        const auto side = sideOf(source.reading);
        document = documentOf(
            source, side ? readRgbdImage(file, *side, &notes) : readImage(file, &notes), display);
        if (!source.depth.empty()) {
            document.rawDepth = readDepthSamples(source.depth, &notes);
        } else if (document.kind == Kind::Scene && document.rawDepth.empty() &&
                   !eyesOf(source.reading)) {
            addPhotoDepth(document, file, notes);
        }
        checkDirection(document, notes);
    }
    document.notes.insert(document.notes.begin(), notes.begin(), notes.end());
    return document;
}

std::vector<Source> pairUp(const std::vector<fs::path>& files) {
    std::vector<tools::FolderFile> photos;
    std::vector<tools::NamedDepth> depths;
    for (const fs::path& file : files) {
        if (isVideoName(file)) continue;
        if (photoOfDepthName(file).empty()) {
            photos.push_back({file});
        } else {
            depths.push_back({file, photoOfDepthName(file)});
        }
    }
    tools::pairDepthImages(depths, photos);
    std::map<fs::path, fs::path> depthOf;
    std::set<fs::path> used;
    for (const tools::FolderFile& photo : photos) {
        depthOf[photo.file] = photo.depth;
        used.insert(photo.depth);
    }
    std::vector<Source> sources;
    for (const fs::path& file : files) {
        if (used.count(file) == 0) sources.push_back({file, depthOf[file], Reading::Automatic});
    }
    leaveOutPhotosOfSplats(sources);
    return sources;
}

} // namespace altiro3D::viewer
