#include "image/panorama.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "image/xmp.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace altiro3D {

namespace {

using std::string_view;

// The first XMP in a file: all formats hold it as it is, in a segment, chunk, tag or box.
string_view xmpOf(string_view bytes) {
    constexpr std::size_t kMost = std::size_t{1} << 20;
    const std::size_t begin = std::min(bytes.find("<x:xmpmeta"), bytes.size());
    const std::size_t end = bytes.find("</x:xmpmeta>", begin);
    return bytes.substr(begin, std::min(end, begin + kMost) - begin);
}

} // namespace

void refuseSphere(const std::filesystem::path& file, string_view bytes, cv::Size size,
                  Notes* notes) {
    constexpr string_view kGPano = "google.com/photos/1.0/panorama";
    constexpr double kHighest = 100; // degrees
    const string_view text = xmpOf(bytes);
    if (text.find(kGPano) == string_view::npos) return;
    const Xmp xmp(text);
    if (xmp.value(kGPano, "ProjectionType") != "equirectangular") return;
    const auto share = [&](const char* part, const char* whole, double unstated) {
        const double of = xmp.number(kGPano, whole);
        const double length = xmp.number(kGPano, part);
        return length > 0 && of >= length ? length / of : unstated;
    };
    const double seen = static_cast<double>(size.width) / size.height;
    const double across = share("CroppedAreaImageWidthPixels", "FullPanoWidthPixels", 1);
    const double down = share("CroppedAreaImageHeightPixels", "FullPanoHeightPixels",
                              std::min(1.0, 2 * across / seen));
    if (180 * down <= kHighest) return;
    const double shape = 2 * across / down / seen;
    const bool isStacked = std::abs(shape / 2 - 1) < 0.1; // both eyes above each other
    if (std::abs(shape - 1) > 0.1 && !isStacked) {
        addNote(
            notes, NoteCode::Doubtful,
            "its XMP (GPano) says that it is a sphere, but it does not have the shape of one: it "
            "is read as a flat picture");
        return;
    }
    // v360 reads whole spheres only. The part lies in their middle, so that yaw 0 looks at it.
    std::string filter;
    if (across < 0.999 || down < 0.999) {
        const double top = xmp.number(kGPano, "CroppedAreaTopPixels") /
                           std::max(1.0, xmp.number(kGPano, "FullPanoHeightPixels"));
        const int width = cvRound(size.width / across);
        const int height = cvRound(size.height / down);
        filter = "pad=" + std::to_string(width) + ":" + std::to_string(height) + ":" +
                 std::to_string((width - size.width) / 2) + ":" +
                 std::to_string(std::clamp(cvRound(height * top), 0, height - size.height)) + ",";
    }
    const int side = std::max(1, cvRound(size.width / across / CV_PI / 4)); // keeps the detail
    filter += std::string("v360=e:flat") + (isStacked ? ":in_stereo=tb:out_stereo=sbs" : "") +
              ":yaw=0:pitch=0:h_fov=90:v_fov=73.74:w=" + std::to_string(4 * side) +
              ":h=" + std::to_string(3 * side);
    const std::string stem = (file.parent_path() / file.stem()).string();
    const std::string name = shellWord(file.string());
    const bool isPair = bytes.find("GImage:Data") != string_view::npos;
    const std::string command =
        isPair ? "exiftool -b -XMP-GImage:ImageData " + name + " | ffmpeg -i " + name +
                     " -i - -filter_complex \"[0]" + filter + "[l];[1]" + filter +
                     "[r];[l][r]hstack\" -frames:v 1 " + shellWord(stem + "_LRF.png")
               : "ffmpeg -i " + name + " -vf " + filter + " -frames:v 1 " +
                     shellWord(stem + (isStacked ? "_LRF.png" : "_flat.png"));
    throw Error(ErrorCode::Unsupported, file.string(),
                "shows " + std::to_string(cvRound(360 * across)) + " x " +
                    std::to_string(cvRound(180 * down)) +
                    " degrees of a sphere by its XMP (GPano), which is not flat, expected a flat "
                    "part of it, as this makes: " +
                    command);
}

} // namespace altiro3D
