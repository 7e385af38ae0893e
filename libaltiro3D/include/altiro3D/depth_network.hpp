#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/export.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

/// Meaning of a network's output.
enum class NetworkOutput {
    InverseDepth, ///< Relative inverse depth, larger = nearer, unknown scale and shift (MiDaS).
    MetricDepth   ///< Distance, larger = farther (FastDepth).
};

/// Order of the colours in a network's input, in a Native, and in a quilt for
/// Quilt2Native::render(). All other pictures are Bgr.
enum class ChannelOrder { Rgb, Bgr };

/// Shape of a network's input.
enum class InputShape {
    Fixed, ///< The input has the size DepthNetwork::inputSize(); every photo is stretched to it.
    Photo  ///< The input has the photo's shape. Its longer side is that of
           ///< DepthNetwork::inputSize(), or the one given to DepthNetwork::estimate().
};

/// How a photo is resampled to the network's input.
enum class ResizeKernel { Nearest, Linear, Cubic, Area };

/// The program that runs the graph of a network.
enum class InferenceEngine {
    Best,       ///< The profile's engine; without one, OnnxRuntime if possible, else OpenCv.
    OpenCv,     ///< OpenCV's DNN module.
    OnnxRuntime ///< ONNX Runtime, several times faster, on the CPU only; see hasOnnxRuntime().
};

/// Whether this library was built with ONNX Runtime. @return true if it was
[[nodiscard]] ALTIRO3D_EXPORT bool hasOnnxRuntime();

/// How to prepare a network's input and interpret its output. A profile is one entry of
/// `models/catalog.json` or a user's JSON file with the same keys. Each channel is converted by
/// `(pixel * scale - mean) / std`.
struct NetworkProfile {
    std::string name;        ///< Short name ("midas-small").
    std::string file;        ///< File name of the ONNX file, without directories.
    std::string url;         ///< Download address; may be empty.
    std::uint64_t bytes = 0; ///< Exact file size; 0 = unknown.
    std::string sha256;      ///< SHA-256 of the file in lower-case hex; empty = unknown.
    std::string licence;     ///< Licence of the weights.
    bool large = false;      ///< True for the large profile (`-l`).
    int inputWidth = 0;      ///< Input width in px, 1..4096.
    int inputHeight = 0;     ///< Input height in px, 1..4096.
    int multipleOf = 32;     ///< Input sides must be multiples of this, 1..4096.
    InputShape inputShape = InputShape::Fixed;       ///< Whether the input has the photo's shape.
    ChannelOrder channelOrder = ChannelOrder::Rgb;   ///< Order of the input's planes.
    double scale = 1.0 / 255.0;                      ///< Factor on 8-bit values.
    std::array<double, 3> mean{0, 0, 0};             ///< Subtracted after scale, in channelOrder.
    std::array<double, 3> std{1, 1, 1};              ///< Divisor after mean, in channelOrder, != 0.
    ResizeKernel resizeKernel = ResizeKernel::Cubic; ///< Used on floats, after scale, before mean.
    NetworkOutput output = NetworkOutput::InverseDepth; ///< Meaning of the output.
    InferenceEngine engine = InferenceEngine::Best;     ///< The engine that it needs; Best: any.
};

/// Whether this library can run a network.
/// @param profile its engine decides
/// @return false if the network needs ONNX Runtime and hasOnnxRuntime() is false
[[nodiscard]] ALTIRO3D_EXPORT bool canRun(const NetworkProfile& profile);

/// Checks a profile.
/// @param profile the profile to check
/// @throws Error InvalidArgument that names the field, its value and the range
ALTIRO3D_EXPORT void validate(const NetworkProfile& profile);

/// Reads one profile from a JSON file.
/// @param file the file, at most 1 MiB
/// @return the profile; it is valid, and its `file` may be empty
/// @throws Error NotFound, ReadFailed, TooLarge, BadFormat (file, field, expected), OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT NetworkProfile readNetworkProfile(const std::filesystem::path& file);

/// Reads a list of at most 1000 networks: `{"networks": [...]}`.
/// @param file the file, at most 1 MiB
/// @return the profiles in the file's order; all are valid, `name` and `file` are unique
/// @throws Error as readNetworkProfile()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NetworkProfile>
readModelCatalog(const std::filesystem::path& file);

/// Finds the catalogue entry of a network file.
/// @param catalog from readModelCatalog(); the result points into it
/// @param modelFile the ONNX file; its directories are ignored
/// @return the entry whose `file` equals the path's file name, or null
[[nodiscard]] ALTIRO3D_EXPORT const NetworkProfile*
findProfile(const std::vector<NetworkProfile>& catalog, const std::filesystem::path& modelFile);

/// The processor a network runs on.
enum class InferenceTarget { Cpu, Cuda };

/// The processor on which networks run here.
/// @param engine that of the network's profile, or the requested one
/// @return CUDA if this OpenCV offers it and the engine may be OpenCV, else the CPU
[[nodiscard]] ALTIRO3D_EXPORT InferenceTarget
bestInferenceTarget(InferenceEngine engine = InferenceEngine::Best);

/// A loaded depth network. Move-only; one thread at a time per object.
///
/// DepthNetwork does not change OpenCV's log level and error callback, which are global to the
/// process. OpenCV logs details of graphs that fail, by default to stderr. The Error is complete
/// without them; cv::utils::logging::setLogLevel() turns the log off. ONNX Runtime 1.21 of Debian
/// 13 writes about a thousand harmless lines to stderr when a process loads its first network.
class ALTIRO3D_EXPORT DepthNetwork {
  public:
    /// Loads an ONNX file.
    /// @param file the ONNX file
    /// @param profile preparation of the input, meaning of the output
    /// @param target processor to run on
    /// @param inputSize size of the network's input, each side 1..4096 px and a multiple of the
    ///        profile's `multipleOf`; empty: the profile's size. Most networks accept sizes other
    ///        than the one they were trained for: a smaller input is faster and resolves less
    ///        detail. For sizes other than the profile's, a reshape at the end of the graph is
    ///        skipped, because it may be fixed to the profile's size.
    /// @param engine program that runs the graph. ONNX Runtime cannot run a file with a fixed size
    ///        at another size; InferenceEngine::Best then chooses OpenCV, unless the profile
    ///        requires ONNX Runtime.
    /// @throws Error NotFound; BadFormat (not an ONNX file, its weights are in a missing file, not
    ///         one input of 3 channels, a graph that the engine cannot load); Mismatch (the file's
    ///         fixed input size differs from the profile's); NetworkFailed (cannot run at
    ///         `inputSize`); Unsupported (its weights are in another file, OpenCV without CUDA,
    ///         CUDA with ONNX Runtime, a library without ONNX Runtime); InvalidArgument (profile,
    ///         inputSize); ReadFailed, TooLarge (2 GiB), OutOfMemory
    DepthNetwork(const std::filesystem::path& file, NetworkProfile profile,
                 InferenceTarget target = InferenceTarget::Cpu, cv::Size inputSize = {},
                 InferenceEngine engine = InferenceEngine::Best);
    ~DepthNetwork();
    DepthNetwork(DepthNetwork&&) noexcept;            ///< Moves.
    DepthNetwork& operator=(DepthNetwork&&) noexcept; ///< Moves. @return *this

    /// The profile in use. @return as given to the constructor
    [[nodiscard]] const NetworkProfile& profile() const;
    /// The input's size as chosen in the constructor. With InputShape::Photo, the size for a given
    /// photo may differ. @return width x height in px
    [[nodiscard]] cv::Size inputSize() const;
    /// The ONNX file. @return as given to the constructor
    [[nodiscard]] const std::filesystem::path& file() const;
    /// The processor that the network runs on. @return as given to the constructor
    [[nodiscard]] InferenceTarget target() const;
    /// The program that runs its graph. @return OpenCv or OnnxRuntime
    [[nodiscard]] InferenceEngine engine() const;

    /// Runs the network on a photo and returns its output unchanged. If the network has several
    /// outputs, the last one is used.
    ///
    /// The output depends on the number of threads and on the processor, because OpenCV or ONNX
    /// Runtime runs the network: with 2 and with 3 threads OpenCV's output may differ in the 7th
    /// digit (docs/reliability.md, "The same bytes").
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param raw [network's output size, CV_32FC1, finite, see NetworkProfile::output]
    /// @throws Error InvalidArgument (empty or wrong type); NetworkFailed (an output of unexpected
    ///         shape or with NaN or infinity, a failure inside the engine); OutOfMemory
    void infer(const cv::Mat& photo, cv::Mat& raw);

    /// infer() followed by normalizeDepth() for the profile's NetworkOutput. As with infer(), the
    /// last digits depend on the number of threads and on the processor.
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param depth [network's output size, CV_32FC1, 0..1, 1 = nearest]
    /// @param longerSide with InputShape::Photo: longer side of the input in px, in the range of
    ///        the constructor's inputSize; 0: that of inputSize(). With InputShape::Fixed it is
    ///        checked, without effect
    /// @throws Error as infer(); InvalidArgument (longerSide)
    void estimate(const cv::Mat& photo, cv::Mat& depth, int longerSide = 0);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Tests a network in a child process: loads it and runs it once. Some malformed files crash OpenCV
/// or make it run forever. Such a file then ends the child and not this process.
///
/// Returns normally for errors that DepthNetwork reports as an Error (not an ONNX file, a graph
/// that the engine rejects, ...). Call it before the process has other threads: fork() copies only
/// the calling thread.
/// @param file the ONNX file
/// @param profile preparation of the input, meaning of the output
/// @param inputSize as for DepthNetwork
/// @param seconds time limit, 0.1..3600 s; the child uses one thread of the CPU
/// @param engine as for DepthNetwork
/// @throws Error NetworkFailed (the child crashes or exceeds the time limit); InvalidArgument
///         (seconds); ReadFailed (the child cannot be started)
ALTIRO3D_EXPORT void probeNetwork(const std::filesystem::path& file, const NetworkProfile& profile,
                                  cv::Size inputSize = {}, double seconds = 120,
                                  InferenceEngine engine = InferenceEngine::Best);

/// Does the work of the child process of probeNetwork() on Windows, where a process cannot be
/// copied: probeNetwork() starts the program again, with other arguments. A program on Windows that
/// does not begin with this call tests networks in its own process.
/// @param arguments those of the program, without its name, in UTF-8
/// @return true if the program was started as this child; it should then end
[[nodiscard]] ALTIRO3D_EXPORT bool answerProbe(const std::vector<std::string>& arguments);

/// Directories that are searched for network files and the catalogue, in this order:
/// - the directories in `$ALTIRO3D_MODELS`, separated by ':' (on Windows ';');
/// - `$XDG_DATA_HOME/altiro3D/models`, or `~/.local/share/altiro3D/models` if that is not absolute
///   (on Windows `%LOCALAPPDATA%\\altiro3D\\models`);
/// - `models/` in each of dataDirectories().
///
/// Directories that do not exist are skipped. The working directory is not searched, so that a
/// folder of pictures from elsewhere cannot supply a network.
/// @return the directories in search order
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::filesystem::path> modelSearchPath();

/// Finds a file in a list of directories. Directories of that name are not accepted.
/// @param name relative file name, such as "midas.onnx"
/// @param searchPath directories, as from modelSearchPath()
/// @return the file in the first directory that contains it; empty if none does, or if `name` is
///         empty or absolute
[[nodiscard]] ALTIRO3D_EXPORT std::filesystem::path
findModelFile(const std::string& name, const std::vector<std::filesystem::path>& searchPath);

/// A network whose file was found.
struct InstalledNetwork {
    NetworkProfile profile;     ///< Its catalogue entry.
    std::filesystem::path file; ///< The ONNX file.
};

/// Reads the first `catalog.json` on a search path.
/// @param searchPath directories, as from modelSearchPath()
/// @return the profiles, preferred ones first; empty if there is no catalogue
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<NetworkProfile>
modelCatalog(const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

/// The networks of the catalogue whose files are on the search path.
/// @param searchPath directories, as from modelSearchPath()
/// @return the networks, preferred ones first
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<InstalledNetwork>
installedNetworks(const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

/// The first of installedNetworks() that canRun() and whose NetworkProfile::large equals `large`.
/// @param large true: the large network
/// @param searchPath directories, as from modelSearchPath()
/// @return the network; nothing if no such network is installed
/// @throws Error as readModelCatalog()
[[nodiscard]] ALTIRO3D_EXPORT std::optional<InstalledNetwork>
standardNetwork(bool large = false,
                const std::vector<std::filesystem::path>& searchPath = modelSearchPath());

} // namespace altiro3D
