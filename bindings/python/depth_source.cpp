#include "arrays.hpp"

#include <altiro3D/depth_network.hpp>

namespace altiro3D::python {

namespace {

// A Python class as a source; it needs only read(photo).
class PythonSource : public DepthSource {
  public:
    [[nodiscard]] std::string description() const override {
        const Locked locked;
        if (const auto method = overrideOf("description")) return method().cast<std::string>();
        return py::str(py::cast(this).get_type().attr("__name__"));
    }
    [[nodiscard]] DepthKind kind() const override {
        const Locked locked;
        const auto method = overrideOf("kind");
        return method ? method().cast<DepthKind>() : DepthKind::NearWhite;
    }
    [[nodiscard]] DepthEdges edges() const override {
        const Locked locked;
        const auto method = overrideOf("edges");
        return method ? method().cast<DepthEdges>() : DepthEdges::Unknown;
    }
    void load() override {
        const Locked locked;
        if (const auto method = overrideOf("load")) method();
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        call("read", image, photo, raw);
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        const Locked locked;
        call(overrideOf("read_frame") ? "read_frame" : "read", image, photo, raw);
    }

  private:
    py::function overrideOf(const char* name) const {
        return py::get_override(static_cast<const DepthSource*>(this), name);
    }
    void call(const char* name, const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) const {
        const Locked locked;
        const auto method = overrideOf(name);
        if (!method) {
            throw Error(ErrorCode::InvalidArgument, description(),
                        "has no method read(self, photo), expected one that returns depth");
        }
        // `photo` may be `image`
        const cv::Mat found = image; // NOLINT(performance-unnecessary-copy-initialization)
        const py::object depth = method(arrayOf(found, Order::Rgb));
        raw = rawDepthOf({depth}, "depth of read()").clone();
        photo = found;
    }
};

// A source of the library: several threads, and other sources, may share it.
class SharedSource : public DepthSource {
  public:
    explicit SharedSource(std::unique_ptr<DepthSource> source) : source_(std::move(source)) {}
    std::string description() const override { return call(&DepthSource::description); }
    DepthKind kind() const override { return call(&DepthSource::kind); }
    DepthEdges edges() const override { return call(&DepthSource::edges); }
    const DepthNetwork* network() const override { return call(&DepthSource::network); }
    void load() override { call(&DepthSource::load); }
    PhotoDepth readPhoto(const PhotoFile& file, Notes* notes) override {
        return call(&DepthSource::readPhoto, file, notes);
    }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        call(&DepthSource::read, image, photo, raw);
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        call(&DepthSource::readFrame, image, photo, raw);
    }

  private:
    template <class Method, class... Arguments>
    std::invoke_result_t<Method, DepthSource&, Arguments&...> call(Method method,
                                                                   Arguments&... given) const {
        const std::lock_guard<Turn> held(turn_);
        return ((*source_).*method)(given...);
    }
    std::unique_ptr<DepthSource> source_;
    mutable Turn turn_{"DepthSource"};
};

std::shared_ptr<DepthSource> shared(std::unique_ptr<DepthSource> source) {
    return std::make_shared<SharedSource>(std::move(source));
}

void bindNetworks(py::module_& m) {
    Value<NetworkProfile>(m, "NetworkProfile",
                          "How to prepare a network's input, and what it gives.")
        .field("name", &NetworkProfile::name, "Short name: midas-small.")
        .field("file", &NetworkProfile::file, "File name of the ONNX file.")
        .field("licence", &NetworkProfile::licence, "Licence of the weights.")
        .field("large", &NetworkProfile::large, "Whether it is a large network.")
        .field("input_width", &NetworkProfile::inputWidth, "px.")
        .field("input_height", &NetworkProfile::inputHeight, "px.")
        .done();
    Value<InstalledNetwork>(m, "InstalledNetwork", "A network whose file was found.")
        .part("profile", &InstalledNetwork::profile, "Its catalogue entry.")
        .field("file", &InstalledNetwork::file, "The ONNX file.")
        .done();
    m.def(
        "installed_networks", [] { return installedNetworks(); },
        "The networks that are installed, preferred ones first.");
    m.def("read_network_profile", &readNetworkProfile, py::arg("file"),
          "Reads the profile of a network from a JSON file.");
}

} // namespace

std::shared_ptr<DepthSource> sourceOf(const py::object& source) {
    auto* const pointer = source.cast<DepthSource*>();
    return {pointer, [kept = keptOf(source)](const DepthSource* /*source*/) {}};
}

void bindDepthSource(py::module_& m) {
    bindNetworks(m);
    py::class_<PhotoDepth>(m, "PhotoDepth", "A photo, and the depth that came with it.")
        .def_property_readonly(
            "photo",
            [](const PhotoDepth& found) { return Array{arrayOf(found.photo, Order::Rgb)}; },
            "uint8 [rows x columns x 3], RGB; a copy.")
        .def_property_readonly(
            "raw_depth", [](const PhotoDepth& found) { return Out{arrayOf(found.rawDepth)}; },
            "Raw numbers [any size]; None: depth must be estimated. Not copied.")
        .def_readonly("kind", &PhotoDepth::kind, "Meaning of the numbers.")
        .def_readonly("text", &PhotoDepth::text, "Where the depth comes from, for people.");
    py::class_<DepthSource, PythonSource, std::shared_ptr<DepthSource>>(
        m, "DepthSource",
        "A source of depth for photos and video frames. To use your own, derive a class with the\n"
        "method read(self, photo): it gets uint8 [rows x columns x 3], RGB, and returns numbers\n"
        "[any size], uint8, uint16, float32 or float64, larger = nearer; any range. kind() may\n"
        "return another meaning of the numbers, description() a name, read_frame(self, photo) may\n"
        "spend less time on frames of videos. Threads may share the library's sources.")
        .def(py::init<>())
        .def("description", &DepthSource::description, "Names the source for people.")
        .def("kind", &DepthSource::kind, "Meaning of the numbers that read() gives.")
        .def("edges", &DepthSource::edges, "What is known of the edges of the depth.")
        .def("load", &DepthSource::load, py::call_guard<Released>(),
             "Loads the network now, not for the first photo.")
        .def(
            "read_photo",
            [](DepthSource& self, const PhotoFile& file, std::optional<py::list> notes) {
                Remarks remarks(std::move(notes));
                PhotoDepth found = unlocked([&] { return self.readPhoto(file, remarks.notes()); });
                remarks.give();
                return found;
            },
            py::arg("file"), py::kw_only(), py::arg("notes") = py::none(),
            "Reads a photo, and depth that comes with it.")
        .def(
            "read",
            [](DepthSource& self, const Array& photo, Order order) {
                const cv::Mat image = pictureOf(photo, "photo", order, {CV_8UC3, CV_16UC3});
                cv::Mat part;
                cv::Mat raw;
                unlocked([&] { self.read(image, part, raw); });
                return Array{arrayOf(std::move(raw))};
            },
            py::arg("photo"), py::kw_only(), py::arg("order") = "rgb",
            "The raw depth numbers of a photo, uint8 [rows x columns x 3].")
        .def(
            "read_scene",
            [](DepthSource& self, const PhotoDepth& found, double flatDepth) {
                Scene scene;
                unlocked([&] { self.readScene(found, flatDepth, scene); });
                return scene;
            },
            py::arg("found"), py::kw_only(), py::arg("flat_depth") = 0.5,
            "The photo of read_photo() and its depth map; flat_depth: result without a range.")
        .def(
            "read_scene",
            [](DepthSource& self, const Array& image, double flatDepth, Order order) {
                const cv::Mat picture = pictureOf(image, "image", order, {CV_8UC3, CV_16UC3});
                Scene scene;
                unlocked([&] { self.readScene(picture, flatDepth, scene); });
                return scene;
            },
            py::arg("image"), py::kw_only(), py::arg("flat_depth") = 0.5, py::arg("order") = "rgb",
            "A photo in memory, uint8 [rows x columns x 3], and its depth map.");
    Value<PhotoDepthOptions>(m, "PhotoDepthOptions", "What stored_depth_or() takes from a file.")
        .field("use_depth", &PhotoDepthOptions::useDepth, "Depth in the file or next to it.")
        .field("unblurred", &PhotoDepthOptions::unblurred, "The sharp original if there is one.")
        .field("named_halves", &PhotoDepthOptions::namedHalves, "Halves that the name states.")
        .constructible()
        .done();
    m.def(
        "estimated_depth", [] { return shared(estimatedDepth()); },
        "Depth estimated by the best installed network, which is loaded when it is needed.");
    m.def(
        "depth_from_network_file",
        [](const std::filesystem::path& file, const NetworkProfile& profile, cv::Size inputSize) {
            return shared(depthFromNetworkFile(file, profile, bestInferenceTarget(profile.engine),
                                               inputSize));
        },
        py::arg("file"), py::arg("profile"), py::kw_only(),
        py::arg_v("input_size", cv::Size(), "(0, 0)"),
        "Depth from an ONNX file, which is loaded when it is needed.");
    m.def(
        "depth_from_file",
        [](const std::filesystem::path& file, DepthKind kind) {
            return shared(depthFromFile(file, kind));
        },
        py::arg("file"), py::kw_only(), py::arg("kind") = DepthKind::NearWhite,
        "Depth from a separate depth image.");
    m.def(
        "depth_from_rgbd",
        [](const RgbdLayout& layout, DepthKind kind) {
            return shared(depthFromRgbd(layout, kind));
        },
        py::kw_only(), py::arg_v("layout", RgbdLayout(), "RgbdLayout()"),
        py::arg("kind") = DepthKind::NearWhite,
        "Depth from RGB-D images, which hold photo and depth side by side.");
    m.def(
        "stored_depth_or",
        [](const py::object& fallback, const PhotoDepthOptions& options) {
            return shared(storedDepthOr(sourceOf(fallback), options));
        },
        py::arg("fallback"), py::kw_only(),
        py::arg_v("options", PhotoDepthOptions(), "PhotoDepthOptions()"),
        "Depth that the photo's file holds or that lies next to it, else that of `fallback`.");
    Value<StereoInput>(m, "StereoInput", "Where the pictures of both eyes are.")
        .field("layout", &StereoInput::layout, "In one picture: order of the eyes.")
        .field("halves", &StereoInput::halves, "In one picture: shape of the halves.")
        .field("right", &StereoInput::right,
               "The right eye's picture; empty: one picture has both.")
        .constructible()
        .done();
    m.def(
        "depth_from_stereo",
        [](const StereoInput& input, const py::object& fallback) {
            return shared(depthFromStereo(input, sourceOf(fallback)));
        },
        py::arg("input"), py::arg("fallback"),
        "Depth of stereo pairs by matching; pairs that do not match take that of `fallback`.");
}

} // namespace altiro3D::python
