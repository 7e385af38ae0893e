#include "cli/page_options.hpp"

#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "cli/run_tool.hpp"

namespace altiro3D::tools {

namespace fs = std::filesystem;

PageOptions::PageOptions(const CommandLine& commandLine) {
    commandLine.take({{"page-side", side, 16, kPageTextureSide}});
    title = commandLine.value("title").value_or("");
    commandLine.refuseWithout("save-page", {"page-side", "title"},
                              " describes a page, expected --save-page with it");
}

void PageOptions::add(CommandLine& commandLine, const std::string& shows, const std::string& more) {
    commandLine.add({"save-page"},
                    "Also write one page that any browser opens without a connection. It shows " +
                        shows + ", and moves with the mouse, a finger or by itself." + more,
                    "FILE.html");
    commandLine.addAdvanced({"page-side"},
                            "Longer side of the picture in the page in px, at most (default " +
                                std::to_string(kPageSide) + ").",
                            "PX");
    commandLine.addAdvanced({"title"}, "Title of the page; default: the name of the file.", "TEXT");
}

PageText PageOptions::text(const fs::path& picture) const {
    const bool isPhoto = canWriteImage(picture) && isFile(picture); // else it has no EXIF
    return {title.empty() && !isStandardStream(picture) ? picture.stem().string() : title,
            isPhoto ? creditOf(picture) : std::string()};
}

void requirePageName(const fs::path& file) {
    if (!file.empty() && !isPageFileName(file))
        throw UsageError(file.string() + ": is not the name of a page, expected .html");
}

void writePage(const fs::path& file, const std::string& page, Messages& messages) {
    writeFile(file, page);
    messages.say(file.string() + ": page for browsers");
}

} // namespace altiro3D::tools
