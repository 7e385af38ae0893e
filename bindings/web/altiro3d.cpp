// The library for JavaScript (embind). src/index.ts is the interface that pages use.

#include <altiro3D/depth_map.hpp>
#include <altiro3D/depth_source.hpp>
#include <altiro3D/display.hpp>
#include <altiro3D/error.hpp>
#include <altiro3D/image_io.hpp>
#include <altiro3D/native_maker.hpp>
#include <altiro3D/recipe.hpp>
#include <altiro3D/sway.hpp>
#include <altiro3D/version.hpp>

#include "base/checks.hpp"
#include "depth/network/network_estimate.hpp"
#include "depth/network/network_input.hpp"
#include "depth/source/photo_depth.hpp"
#include "image/depth_of_part.hpp"
#include "image/depth_parts.hpp"
#include "image/exif.hpp"
#include "image/image_codecs.hpp"
#include "image/picture_halves.hpp"

#include <cstdint>
#include <emscripten/bind.h>
#include <emscripten/val.h>
#include <filesystem>
#include <malloc.h>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D::web {

namespace {

using emscripten::val;

// Calls a function and turns its exception into a JavaScript Error. That Error leaves C++ without
// running destructors, so it is thrown when no object is left.
template <class Work>
auto guarded(const Work& work) {
    static std::string message;
    try {
        return work();
    } catch (const std::exception& exception) {
        message = exception.what();
    }
    val::global("Error").new_(message).throw_();
}

// Pictures and numbers from JavaScript

template <class T>
cv::Mat matOf(const val& values, cv::Size size, int channels) {
    cv::Mat result(size, CV_MAKETYPE(cv::DataType<T>::depth, channels));
    const val memory(emscripten::typed_memory_view(result.total() * channels, result.ptr<T>()));
    memory.call<void>("set", values);
    return result;
}

// @param picture with data, width and height
cv::Size sizeOf(const val& picture, const char* subject, unsigned channels) {
    constexpr double kMostPixels = 1 << 28;
    const auto columns = picture["width"].as<double>();
    const auto rows = picture["height"].as<double>();
    check(columns >= 1 && rows >= 1 && columns * rows <= kMostPixels, subject,
          "is " + numberText(columns) + " x " + numberText(rows) + " px, expected 1 to 2^28 px");
    const cv::Size size(static_cast<int>(columns), static_cast<int>(rows));
    const auto length = picture["data"]["length"].as<double>();
    check(length == static_cast<double>(channels) * size.area(), subject,
          "has " + numberText(length, 12) + " values, expected " + std::to_string(channels) +
              " for each of " + sizeText(size));
    return size;
}

cv::Mat photoOf(const val& image) {
    const cv::Mat rgba = matOf<std::uint8_t>(image["data"], sizeOf(image, "photo", 4), 4);
    cv::Mat photo;
    cv::cvtColor(rgba, photo, cv::COLOR_RGBA2BGR);
    return photo;
}

cv::Mat depthOf(const val& depth) {
    const cv::Size size = sizeOf(depth, "depth", 1);
    const val data = depth["data"];
    const auto type = data["constructor"]["name"].as<std::string>();
    if (type == "Float32Array") return matOf<float>(data, size, 1);
    if (type == "Uint16Array") return matOf<std::uint16_t>(data, size, 1);
    if (type == "Uint8Array" || type == "Uint8ClampedArray")
        return matOf<std::uint8_t>(data, size, 1);
    throw Error(ErrorCode::InvalidArgument, "depth",
                "is of " + type + ", expected Float32Array, Uint16Array or Uint8Array");
}

bool isGiven(const val& options, const char* name) {
    return !options[name].isUndefined() && !options[name].isNull();
}

double numberOr(const val& options, const char* name, double usual) {
    if (!isGiven(options, name)) return usual;
    check(options[name].isNumber(), name, "is not a number, expected one");
    return options[name].as<double>();
}

// The part of a file that a browser has decoded: RGBA, or numbers; empty if that failed.
cv::Mat decodedOf(const val& picture) {
    if (picture.isUndefined()) return {};
    const auto pixels = picture["width"].as<double>() * picture["height"].as<double>();
    if (picture["data"]["length"].as<double>() == pixels) return depthOf(picture);
    return matOf<std::uint8_t>(picture["data"], sizeOf(picture, "picture", 4), 4);
}

template <class T>
T oneOf(const val& options, const char* name, const std::map<std::string, T>& values, T usual) {
    if (!isGiven(options, name)) return usual;
    const std::string text = options[name].isString() ? options[name].as<std::string>() : "?";
    const auto found = values.find(text);
    if (found != values.end()) return found->second;
    std::string expected;
    for (const auto& [value, meaning] : values)
        expected += (expected.empty() ? "" : ", ") + value;
    throw Error(ErrorCode::InvalidArgument, name,
                "is \"" + shortened(text) + "\", expected one of " + expected);
}

// Pictures to JavaScript

template <class T>
val arrayOf(const char* type, const T* values, std::size_t count) {
    val array = val::global(type).new_(static_cast<double>(count));
    array.call<void>("set", val(emscripten::typed_memory_view(count, values)));
    return array;
}

template <class T>
val pictureOf(const char* type, const cv::Mat& picture) {
    val result = val::object();
    result.set("data", arrayOf(type, picture.ptr<T>(), picture.total() * picture.channels()));
    result.set("width", picture.cols);
    result.set("height", picture.rows);
    return result;
}

val imageOf(const cv::Mat& bgr) {
    cv::Mat rgba;
    cv::cvtColor(bgr, rgba, cv::COLOR_BGR2RGBA);
    return pictureOf<std::uint8_t>("Uint8ClampedArray", rgba);
}

val pngOf(const cv::Mat& bgr, ImageMark mark) {
    const std::vector<unsigned char> file =
        encodePng(bgr, mark == ImageMark::Native ? kNativeMark : std::string_view());
    return arrayOf("Uint8Array", file.data(), file.size());
}

val listOf(const Notes& notes) {
    val list = val::array();
    for (const Note& note : notes)
        list.call<void>("push", note.text);
    return list;
}

// Displays and scenes

Display displayOfText(const std::string& text, const std::string& name) {
    return guarded([&] { return displayOf(parseCalibrations(text, name).front(), name); });
}

val factsOf(const Display& display) {
    const DisplayModel* const model = findDisplayModel(display.calibration);
    val facts = val::object();
    facts.set("serial", display.calibration.serial);
    facts.set("model", model != nullptr ? model->name : std::string());
    facts.set("width", display.panelSize().width);
    facts.set("height", display.panelSize().height);
    facts.set("aspect", display.aspect());
    facts.set("views", display.quilt.viewCount);
    facts.set("remarks", listOf(calibrationWarnings(display.calibration)));
    return facts;
}

const std::map<std::string, DepthKind> kDepthKinds{{"near-white", DepthKind::NearWhite},
                                                   {"far-white", DepthKind::FarWhite},
                                                   {"metric", DepthKind::Metric}};

Scene sceneOf(const val& image, const val& depth) {
    return guarded([&] {
        Scene scene;
        scene.photo = photoOf(image);
        DepthNormalization normalization;
        normalization.kind = oneOf(depth, "kind", kDepthKinds, DepthKind::NearWhite);
        normalizeDepth(depthOf(depth), scene.depth, normalization);
        if (depth["estimated"].isTrue()) scene.edges = DepthEdges::Aligned;
        return scene;
    });
}

val photoOfScene(const Scene& scene) {
    return guarded([&] { return imageOf(scene.photo); });
}

val depthOfScene(const Scene& scene) {
    return guarded([&] {
        val result = pictureOf<float>("Float32Array", scene.depth);
        result.set("estimated", scene.edges == DepthEdges::Aligned);
        return result;
    });
}

// Depth that came with a photo

// @param found without rawDepth: the depth of its photo must be estimated, or there is nothing
val foundOf(const PhotoDepth& found, const Notes& notes) {
    val result = val::object();
    if (!found.rawDepth.empty()) {
        Scene scene;
        makeScene(found, DepthNormalization().flatDepth, scene);
        result.set("scene", scene);
    } else if (!found.photo.empty()) {
        result.set("photo", imageOf(found.photo));
    }
    result.set("text", found.text);
    result.set("remarks", listOf(notes));
    return result;
}

val matchEyes(const val& left, const val& right) {
    return guarded([&] {
        const StereoPair pair{photoOf(left), photoOf(right), "two pictures"};
        Notes notes;
        const PhotoDepth found = matchedDepth(pair, notes);
        return foundOf(found, notes);
    });
}

val splitEyes(const val& picture, const val& options) {
    return guarded([&] {
        const StereoLayout layout = oneOf(options, "layout",
                                          {{"left-right", StereoLayout::LeftRight},
                                           {"right-left", StereoLayout::RightLeft},
                                           {"top-bottom", StereoLayout::TopBottom},
                                           {"bottom-top", StereoLayout::BottomTop}},
                                          StereoLayout::LeftRight);
        const StereoHalves halves = oneOf(
            options, "halves", {{"full", StereoHalves::Full}, {"squeezed", StereoHalves::Squeezed}},
            StereoHalves::Automatic);
        const StereoPair pair = splitStereoPair(photoOf(picture), layout, halves);
        val result = val::object();
        result.set("left", imageOf(pair.left));
        result.set("right", imageOf(pair.right));
        return result;
    });
}

// The file of a photo, with what it holds besides the picture that browsers show.
class StoredDepth {
  public:
    StoredDepth(std::string bytes, std::string name)
        : bytes_(std::move(bytes)), name_(std::move(name)) {
        if (imageFormat(bytes_) != ImageFormat::Jpeg) return;
        part_ = findDepthPart(bytes_);
        eye_ = findSecondEye(bytes_);
    }

    // Files inside the file.
    val depthPicture() const { return arrayOf(part_ ? part_->picture() : std::string_view()); }
    val secondEye() const { return arrayOf(eye_.coded); }

    // @param depth, eye: those files, decoded and not turned
    val scene(const val& image, const val& depth, const val& eye) const {
        Notes notes;
        const PhotoDepth found = find(photoOf(image), decodedOf(depth), decodedOf(eye), notes);
        return foundOf(found, notes);
    }

  private:
    static val arrayOf(std::string_view bytes) {
        return web::arrayOf("Uint8Array", reinterpret_cast<const std::uint8_t*>(bytes.data()),
                            bytes.size());
    }

    // As storedDepthOr() does it.
    PhotoDepth find(const cv::Mat& photo, const cv::Mat& depth, const cv::Mat& eye,
                    Notes& notes) const {
        if (part_) {
            const cv::Mat samples = samplesOf(*part_, depth);
            if (const auto usable = depthOfPart(*part_, samples, photo.size(), &notes)) {
                PhotoDepth found;
                found.photo = photo;
                found.rawDepth = usable->depth;
                found.origin = DepthOrigin::Given;
                found.text = "depth in the photo's file (" + usable->text() + ")";
                return found;
            }
        }
        if (const std::optional<StereoPair> pair = pairOf(photo, eye, notes)) {
            Notes own;
            PhotoDepth found = matchedDepth(*pair, own);
            addNotes(&notes, own);
            return found;
        }
        refuseVrName(name_);
        const std::optional<SceneName> name = parseSceneName(name_);
        if (!name || name->contents != SceneName::Contents::Eyes) return {};
        return matchedDepth(*name, photo, name_, bytes_, &notes).value_or(PhotoDepth());
    }

    std::optional<StereoPair> pairOf(const cv::Mat& photo, const cv::Mat& eye, Notes& notes) const {
        const MarkedEyes marked = findMarkedEyes(name_, bytes_, &notes);
        if (marked.eyes) return splitMarkedEyes(photo, marked, name_, &notes);
        if (eye_.coded.empty()) return std::nullopt;
        const char* problem = "it is damaged";
        if (eye.channels() == 4) {
            StereoPair pair{photo, {}, "MPO"};
            cv::cvtColor(upright(eye, eye_.orientation), pair.right, cv::COLOR_RGBA2BGR);
            if (canBeEyes(pair.left.size(), pair.right.size())) return pair;
            problem = "its shape is not that of the left picture";
        }
        addNote(&notes, NoteCode::LeftOut,
                std::string("the right eye's picture is not used: ") + problem);
        return std::nullopt;
    }

    std::string bytes_;
    std::string name_;
    std::optional<DepthPart> part_; // points into bytes_
    SecondEye eye_;                 // points into bytes_ as well
};

// The depth of a photo by a network that JavaScript runs.
class Estimate {
  public:
    Estimate(const val& image, const val& given)
        : photo_(photoOf(image)), profile_(profileOf(given)) {
        validate(profile_);
        const cv::Size nominal(profile_.inputWidth, profile_.inputHeight);
        runs_ = runsOfPhoto(profile_, nominal, photo_);
        depths_.resize(runs_.size());
    }

    int runs() const { return static_cast<int>(runs_.size()); }

    // Input of the network: planes, rows x columns each.
    val input(int run) {
        const NetworkRun& wanted = runs_.at(run);
        const cv::Size nominal(profile_.inputWidth, profile_.inputHeight);
        const int side =
            wanted.longerSide > 0 ? wanted.longerSide : std::max(nominal.width, nominal.height);
        const cv::Size size = networkInputSize(profile_, nominal, wanted.photo.size(), side);
        const cv::Mat& blob = input_.make(profile_, wanted.photo, size);
        val result = val::object();
        result.set("data", arrayOf("Float32Array", blob.ptr<float>(), blob.total()));
        result.set("width", size.width);
        result.set("height", size.height);
        return result;
    }

    // Output of the network.
    void setOutput(int run, const val& output) {
        const cv::Mat raw = matOf<float>(output["data"], sizeOf(output, "network", 1), 1);
        check(cv::checkRange(raw), "network",
              "puts out NaN or infinity for this picture, expected finite numbers");
        DepthNormalization normalization;
        if (profile_.output == NetworkOutput::MetricDepth) normalization.kind = DepthKind::Metric;
        normalizeDepth(raw, depths_.at(run), normalization);
    }

    val depth() const {
        const cv::Mat depth = depthOfRuns(photo_.size(), runs_.front().photo, depths_);
        val result = pictureOf<float>("Float32Array", depth);
        result.set("estimated", true);
        return result;
    }

  private:
    static NetworkProfile profileOf(const val& given) {
        NetworkProfile profile;
        profile.name = profile.file = "network";
        profile.inputWidth = static_cast<int>(numberOr(given, "inputWidth", 0));
        profile.inputHeight = static_cast<int>(numberOr(given, "inputHeight", 0));
        profile.multipleOf = static_cast<int>(numberOr(given, "multipleOf", profile.multipleOf));
        profile.inputShape =
            oneOf(given, "inputShape", {{"fixed", InputShape::Fixed}, {"photo", InputShape::Photo}},
                  InputShape::Fixed);
        profile.channelOrder =
            oneOf(given, "channelOrder", {{"RGB", ChannelOrder::Rgb}, {"BGR", ChannelOrder::Bgr}},
                  ChannelOrder::Rgb);
        profile.scale = numberOr(given, "scale", profile.scale);
        for (int i = 0; i < 3; ++i) {
            if (isGiven(given, "mean")) profile.mean[i] = given["mean"][i].as<double>();
            if (isGiven(given, "std")) profile.std[i] = given["std"][i].as<double>();
        }
        profile.resizeKernel = oneOf(given, "resizeKernel",
                                     {{"nearest", ResizeKernel::Nearest},
                                      {"linear", ResizeKernel::Linear},
                                      {"cubic", ResizeKernel::Cubic},
                                      {"area", ResizeKernel::Area}},
                                     ResizeKernel::Cubic);
        profile.output = oneOf(given, "output",
                               {{"inverseDepth", NetworkOutput::InverseDepth},
                                {"metricDepth", NetworkOutput::MetricDepth}},
                               NetworkOutput::InverseDepth);
        return profile;
    }

    cv::Mat photo_;
    NetworkProfile profile_;
    NetworkInput input_;
    std::vector<NetworkRun> runs_;
    std::vector<cv::Mat> depths_;
};

// The settings of a picture. What is not given is chosen as photo2native does.
// @param given with the fields of a recipe; "depth-curve" is depthCurve
Recipe recipeOf(const val& given) {
    Recipe recipe;
    recipe.choices = {!isGiven(given, "fit"), !isGiven(given, "focus"), false,
                      !isGiven(given, "strength")};
    for (const RecipeField& field : recipeFields()) {
        std::string name;
        for (std::size_t i = 0; i < field.name.size(); ++i) {
            const bool isNewWord = i > 0 && field.name[i - 1] == '-';
            if (field.name[i] != '-')
                name += isNewWord ? static_cast<char>(field.name[i] - 'a' + 'A') : field.name[i];
        }
        if (!isGiven(given, name.c_str())) continue;
        const auto text = given[name].call<std::string>("toString");
        if (!field.read(recipe, text))
            throw Error(ErrorCode::InvalidArgument, name,
                        "is \"" + shortened(text) + "\", expected " + field.expected);
    }
    return recipe;
}

// A scene on a display
class Rendering {
  public:
    Rendering(const Display& display, Scene scene, const val& given)
        : display_(display), scene_(std::move(scene)), maker_(makerOf(given)) {}

    val native() { return imageOf(makeNative()); }
    val nativePng() { return pngOf(makeNative(), ImageMark::Native); }
    val quilt() { return imageOf(makeQuilt()); }
    val quiltPng() { return pngOf(makeQuilt(), ImageMark::None); }

    // @param rows of the view; it has the panel's shape
    val view(double position, int rows) {
        if (!sway_ || rows != swayRows_) {
            const cv::Size size(std::max(1, cvRound(rows * display_.aspect())), rows);
            swayScene_ = placeScene(scene_, display_.aspect(), size, options());
            sway_ = photoViews(swayScene_.scene, options().views);
            swayRows_ = rows;
        }
        sway_(position, view_);
        return imageOf(view_);
    }

    val chosen() const {
        val result = val::object();
        result.set("strength", options().views.strengthPercent);
        result.set("focus", options().views.focus);
        result.set("zoom", options().framing.zoom);
        result.set("centreX", options().framing.centre.x);
        result.set("centreY", options().framing.centre.y);
        return result;
    }

    std::string quiltName(const std::string& photo) const {
        const std::filesystem::path file = std::filesystem::path(photo).replace_extension(".png");
        return quiltFileName(file, maker_.layout(), display_.aspect()).string();
    }

  private:
    const NativeOptions& options() const { return maker_.options(); }

    NativeMaker makerOf(const val& given) const {
        Recipe recipe = recipeOf(given);
        if (!isGiven(given, "detail")) recipe.detail = Detail::Lens;
        if (recipe.detail != Detail::View && NativeMaker::obstacle(display_.quilt, recipe).empty())
            recipe.showAs(recipe.detail);
        static_cast<PlacementOptions&>(recipe) =
            chooseFromScene(scene_, display_.aspect(), display_.quilt, recipe, recipe.choices)
                .options;
        return NativeMaker(display_, recipe);
    }

    const cv::Mat& makeNative() {
        const Placement placed =
            placeScene(scene_, display_.aspect(), maker_.workSize(), options());
        maker_.makeNative(placed, native_);
        return native_;
    }

    const cv::Mat& makeQuilt() {
        const Placement placed =
            placeScene(scene_, display_.aspect(), maker_.quiltSize(), options());
        maker_.makeQuilt(placed.scene, quilt_);
        return quilt_;
    }

    Display display_;
    Scene scene_;
    NativeMaker maker_;
    Placement swayScene_;
    SwayView sway_;
    int swayRows_ = 0;
    cv::Mat view_;
    cv::Mat native_;
    cv::Mat quilt_;
};

Rendering* newRendering(const Display& display, const Scene& scene, const val& options) {
    return guarded([&] { return new Rendering(display, scene, options); });
}

StoredDepth* newStoredDepth(const std::string& bytes, const std::string& name) {
    return guarded([&] { return new StoredDepth(bytes, name); });
}

Estimate* newEstimate(const val& image, const val& profile) {
    return guarded([&] { return new Estimate(image, profile); });
}

// A member function whose exceptions become Errors of JavaScript.
template <auto kFunction, class Self, class... Arguments>
auto call(Self& self, Arguments... arguments) {
    return guarded([&] { return (self.*kFunction)(arguments...); });
}

} // namespace

EMSCRIPTEN_BINDINGS(altiro3d) {
    using emscripten::allow_raw_pointers;
    emscripten::class_<Display>("Display").constructor(&displayOfText).property("facts", &factsOf);
    emscripten::class_<Scene>("Scene")
        .constructor(&sceneOf)
        .function("photo", &photoOfScene)
        .function("depth", &depthOfScene);
    emscripten::class_<StoredDepth>("StoredDepth")
        .constructor(&newStoredDepth, allow_raw_pointers())
        .function("depthPicture", &StoredDepth::depthPicture)
        .function("secondEye", &StoredDepth::secondEye)
        .function("scene", &call<&StoredDepth::scene, const StoredDepth, val, val, val>);
    emscripten::function("matchEyes", &matchEyes);
    emscripten::function("splitEyes", &splitEyes);
    emscripten::class_<Estimate>("Estimate")
        .constructor(&newEstimate, allow_raw_pointers())
        .function("runs", &Estimate::runs)
        .function("input", &call<&Estimate::input, Estimate, int>)
        .function("setOutput", &call<&Estimate::setOutput, Estimate, int, val>)
        .function("depth", &call<&Estimate::depth, const Estimate>);
    emscripten::class_<Rendering>("Rendering")
        .constructor(&newRendering, allow_raw_pointers())
        .function("native", &call<&Rendering::native, Rendering>)
        .function("nativePng", &call<&Rendering::nativePng, Rendering>)
        .function("quilt", &call<&Rendering::quilt, Rendering>)
        .function("quiltPng", &call<&Rendering::quiltPng, Rendering>)
        .function("view", &call<&Rendering::view, Rendering, double, int>)
        .function("chosen", &call<&Rendering::chosen, const Rendering>)
        .function("quiltName", &call<&Rendering::quiltName, const Rendering, std::string>);
    emscripten::function("setThreads", &cv::setNumThreads);
    // For tests. Of type double, as JavaScript has it.
    emscripten::function(
        "memoryInUse", +[] { return static_cast<double>(mallinfo().uordblks); });
    emscripten::function(
        "version", +[] { return std::string(ALTIRO3D_VERSION); });
}

} // namespace altiro3D::web
