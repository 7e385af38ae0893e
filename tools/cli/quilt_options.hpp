#pragma once

#include "altiro3D/print_sheet.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/quilt2native.hpp"
#include "cli/display_options.hpp"

#include <filesystem>
#include <optional>
#include <string>

/// Options about the quilt: its layout, and how a Native is made of it.
namespace altiro3D::tools {

/// -q -r
void addQuiltOptions(CommandLine& commandLine);
/// --view-filter --sampling
void addSamplingOptions(CommandLine& commandLine, const std::string& standard = "nearest");
/// @param standard without --sampling @throws UsageError
QuiltSampling samplingOption(const CommandLine& commandLine,
                             TileSampling standard = TileSampling::Nearest);
/// The same for quilts that come as pictures: px inside a view are blended, unless `--sampling
/// nearest` or `-m` is given. A px of a view covers several px of the panel, and would become
/// coloured noise if it were repeated there.
QuiltSampling pictureSampling(const CommandLine& commandLine);
ViewFilter viewFilterOption(const CommandLine& commandLine);

/// Reports black bars that keep the shape of a quilt's views, unless the user asked for them. Warns
/// if the views are stretched, as their shape is not known.
void tellShape(const QuiltShape& shape, Messages& messages);

std::string stretchText(const QuiltShape& shape);

/// A quilt's layout as text for people: QuiltLayout::text(), followed by the shape of the views if
/// their px are not square.
/// @param aspect width : height of a view as it is shown
std::string quiltText(const QuiltLayout& layout, double aspect);

/// resolveQuilt() for a request of the command line: errors and warnings name `-q` and `-r`.
ResolvedQuilt resolveLayout(const QuiltRequest& request, const QuiltLayout& standard,
                            double panelAspect);
/// `-q` and `-r`. @throws UsageError
QuiltRequest quiltRequest(const CommandLine& commandLine);

/// Whether the layout of a quilt file is stated: by `-q` and `-r`, or by its name.
bool isLayoutStated(const QuiltRequest& request, const std::filesystem::path& quiltFile);

/// The layout that was found in a picture, if it is certain; none if it is not, but the picture has
/// the size of `usual`, which is then the best guess.
/// @throws Error BadFormat (no quilt), UsageError (not certain)
std::optional<QuiltGrid> certainLayout(const FoundQuilt& found, const std::filesystem::path& file,
                                       cv::Size size, const QuiltLayout& usual);

/// Whether a picture is a quilt, by what was found in it; if that is unsure, by its size.
/// @param usual the layout that it would have
bool isQuiltPicture(const FoundQuilt& found, cv::Size picture, const QuiltLayout& usual);

/// "; found in the picture, 97 % sure"
std::string foundText(const FoundQuilt& found);

/// The quilt's layout from a request of the command line, a quilt's file name, its size, and what
/// was found in it. The caller reports it with quiltText() and foundText().
/// @param quiltFile the input quilt, if there is one
/// @param quiltSize its size in px
/// @param found what was found in it; only if its layout is not stated
QuiltLayout chooseQuilt(QuiltRequest request, const ChosenDisplay& display, Messages& messages,
                        const std::optional<std::filesystem::path>& quiltFile = std::nullopt,
                        std::optional<cv::Size> quiltSize = std::nullopt,
                        const std::optional<FoundQuilt>& found = std::nullopt);

/// The renderer of quilts: by the map of `-m`, if there is one, nothing is blended, and the display
/// has no lens sheet, whose Native may be too large for memory.
Quilt2Native makeQuilt2Native(const QuiltSampling& sampling, const ChosenDisplay& display,
                              const QuiltLayout& layout);

/// Renders a quilt and writes the Native, or the print.
void makeNativeFile(const Quilt2Native& renderer, const cv::Mat& quilt,
                    const std::filesystem::path& output, const std::optional<PrintSheet>& print,
                    Messages& messages, StageTimes& times);

} // namespace altiro3D::tools
