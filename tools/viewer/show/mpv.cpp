#include "altiro3D/altiro3D.hpp"
#include "viewer/show/presentation.hpp"

#include <cmath>
#include <system_error>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

// The layout that the names of all files state.
QuiltLayout commonLayout(const std::vector<Source>& files, double panelAspect,
                         tools::Messages& messages) {
    std::optional<QuiltGrid> common;
    for (const Source& source : files) {
        const auto name = parseQuiltName(source.file);
        if (!name)
            throw Error(ErrorCode::BadFormat, source.file.string(),
                        "is not named as a quilt, but --player mpv plays quilts only; expected a "
                        "name that ends in _qs<columns>x<rows>a<aspect>");
        if (name->aspect && !haveSameShape(*name->aspect, panelAspect))
            messages.warn(source.file.string() + ": is stretched to the shape of the panel");
        if (!common) common = name->grid;
        if (common->columns != name->grid.columns || common->rows != name->grid.rows)
            throw Error(ErrorCode::Mismatch, source.file.string(),
                        "has another layout than " + files.front().file.string() +
                            ", expected one layout with --player mpv");
    }
    return {common->columns, common->rows, {1, 1}, common->columns * common->rows};
}

} // namespace

fs::path writeMpvShader(const Display& display, const std::vector<Source>& files,
                        tools::Messages& messages) {
    const QuiltLayout layout = commonLayout(files, display.aspect(), messages);
    const fs::path folder = tools::cacheDirectory();
    if (folder.empty())
        throw Error(ErrorCode::NotFound, "shader", "has no place, expected $HOME to be set");
    std::error_code ignored; // writing reports it
    fs::create_directories(folder, ignored);
    fs::path shader = folder / "shader-of-mpv.glsl";
    writeFile(shader, quiltShader(display.calibration, layout,
                                  {ViewFilter::Nearest, TileSampling::Linear}, display.invert));
    return shader;
}

void becomeMpv(const ShowJob& job, const std::vector<Source>& files, const fs::path& shader,
               const std::string& screen) {
    const SlideShow::Settings& slides = job.slides;
    const bool isSingle = files.size() == 1;
    std::vector<std::string> words{
        "mpv", "--no-config", "--vo=gpu", "--fs", "--screen-name=" + screen,
        "--fs-screen-name=" + screen, "--no-keepaspect", "--hwdec=auto-safe", "--dither-depth=no",
        "--osc=no", "--image-display-duration=" + (isSingle ? "inf" : fixed(slides.each, 1)),
        // mpv's volume is the cube root of the amplitude
        "--volume=" + fixed(100 * std::cbrt(job.play.volume / 100.0), 1),
        "--glsl-shader=" + shader.string()};
    if (job.play.muted) words.emplace_back("--mute=yes");
    if (slides.shuffles) words.emplace_back("--shuffle");
    if (slides.loops || isSingle) words.emplace_back("--loop-playlist=inf");
    words.emplace_back("--");
    for (const Source& source : files) // absolute: never a protocol of mpv's
        words.push_back(fs::absolute(source.file).string());
    const int number = tools::becomeProgram(words);
    throw Error(ErrorCode::NotFound, "mpv",
                "cannot be started (" + std::generic_category().message(number) +
                    "), expected the program mpv to be installed");
}

} // namespace altiro3D::viewer
