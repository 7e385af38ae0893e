// Names of picture files: which files of a directory are pictures and their order, and what names
// say about depth, both eyes and VR.

#include "altiro3D/image_io.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/image_format.hpp"
#include "base/text.hpp"
#include "image/image_read.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kSeparators = "-_. ";
constexpr std::string_view kDigits = "0123456789";
constexpr std::array<std::string_view, 4> kWords = {"depth", "depthmap", "depth_map", "disparity"};
constexpr std::string_view kWith = "with"; // a_with_depth.jpg is a photo that holds its depth

// Whether it ends with a separator and the word.
bool endsWithWord(std::string_view text, std::string_view smallWord) {
    if (text.size() <= smallWord.size()) return false;
    const std::size_t at = text.size() - smallWord.size();
    return kSeparators.find(text[at - 1]) != std::string_view::npos &&
           std::equal(smallWord.begin(), smallWord.end(), text.begin() + at,
                      [](char small, char c) { return small == lowerCase(c); });
}

// Words that say how both eyes are arranged.
struct EyesTags {
    std::array<const char*, 6> words; // some, then null
    StereoLayout layout;
    StereoHalves halves;
};

constexpr EyesTags kEyesTags[] = {
    {{"lr", "sbs", "2x1", "3dh", "3dph"}, StereoLayout::LeftRight, StereoHalves::Automatic},
    {{"hsbs", "sbsh", "halfsbs", "lrh"}, StereoLayout::LeftRight, StereoHalves::Squeezed},
    {{"lrf", "fsbs", "sbsf", "fullsbs", "3dhf", "3dphf"},
     StereoLayout::LeftRight,
     StereoHalves::Full},
    {{"rl", "cross"}, StereoLayout::RightLeft, StereoHalves::Automatic},
    {{"rlf"}, StereoLayout::RightLeft, StereoHalves::Full},
    {{"tb", "tab", "ou", "1x2", "3dv", "3dpv"}, StereoLayout::TopBottom, StereoHalves::Automatic},
    {{"htb", "htab", "hou", "halfou", "halftab", "tbh"},
     StereoLayout::TopBottom,
     StereoHalves::Squeezed},
    {{"tbf", "fulltb", "3dvf", "3dpvf", "ftab", "fou"},
     StereoLayout::TopBottom,
     StereoHalves::Full},
};

struct Word {
    std::string text; // as in the name
    std::string lower;
    std::size_t at; // in the stem
};

std::vector<Word> wordsOf(const std::string& stem) {
    std::vector<Word> words;
    bool isInWord = false;
    for (std::size_t i = 0; i < stem.size(); ++i) {
        const bool isLetter = std::isalnum(static_cast<unsigned char>(stem[i])) != 0;
        if (isLetter && !isInWord) words.push_back({{}, {}, i});
        isInWord = isLetter;
        if (!isLetter) continue;
        words.back().text += stem[i];
        words.back().lower += lowerCase(stem[i]);
    }
    return words;
}

// Whether the word numbers the files of a sequence: another file has another number there.
bool isRunningNumber(const fs::path& file, const Word& word) {
    const std::string name = file.filename().string();
    const std::string before = name.substr(0, word.at);
    const std::string after = name.substr(word.at + word.text.size());
    std::error_code error;
    const fs::path directory = file.parent_path();
    fs::directory_iterator entry(directory.empty() ? fs::path(".") : directory, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const std::string other = entry->path().filename().string();
        if (other.size() <= before.size() + after.size() || !startsWith(other, before) ||
            !endsWith(other, after))
            continue;
        const std::string number =
            other.substr(before.size(), other.size() - before.size() - after.size());
        if (std::all_of(number.begin(), number.end(), isDigit) && number != "180" &&
            number != "360")
            return true;
    }
    return false;
}

const Word* findVr(const fs::path& file, const std::vector<Word>& words) {
    static const std::set<std::string> kTags = {"180x180", "360x180", "360x360", "vr180", "180vr",
                                                "vr360",   "360vr",   "mono360", "180sbs"};
    for (std::size_t i = 1; i < words.size(); ++i) {
        const Word& word = words[i];
        const bool isNumber = word.lower == "180" || word.lower == "360";
        if (kTags.count(word.lower) > 0 || (isNumber && !isRunningNumber(file, word))) return &word;
    }
    return nullptr;
}

// Whether a file without an extension is a picture by its first bytes.
bool isNamelessPicture(const fs::path& file) {
    return file.extension().empty() &&
           imageFormat(PhotoFile(file).start(512)) != ImageFormat::Unknown;
}

} // namespace

std::optional<SceneName> parseSceneName(const fs::path& file) {
    const std::vector<Word> words = wordsOf(file.stem().string());
    SceneName name;
    if (const Word* const word = findVr(file, words)) {
        name.contents = SceneName::Contents::Vr;
        name.tag = word->text;
        return name;
    }
    std::optional<SceneName> eyes;
    std::optional<SceneName> rgbd;
    bool isStacked = false;
    for (std::size_t i = 1; i < words.size(); ++i) {
        const Word& word = words[i];
        if (word.lower == "rgbd" || word.lower == "hrgbd") {
            const StereoHalves halves =
                word.lower == "rgbd" ? StereoHalves::Full : StereoHalves::Squeezed;
            rgbd = SceneName{SceneName::Contents::Rgbd, word.text, {}, false, halves};
        }
        isStacked = isStacked || word.lower == "topbottom";
        for (const EyesTags& tag : kEyesTags) {
            const auto isTag = [&](const char* each) {
                return each != nullptr && word.lower == each;
            };
            if (std::none_of(tag.words.begin(), tag.words.end(), isTag)) continue;
            eyes = SceneName{SceneName::Contents::Eyes, word.text, tag.layout, false, tag.halves};
            for (const std::size_t beside : {i - 1, std::min(i + 1, words.size() - 1)}) {
                if (words[beside].lower == "full") eyes->halves = StereoHalves::Full;
                if (words[beside].lower == "half") eyes->halves = StereoHalves::Squeezed;
            }
        }
    }
    if (!rgbd) return eyes;
    rgbd->isStacked = isStacked || (eyes && eyes->layout == StereoLayout::TopBottom);
    return rgbd;
}

StereoHalves halvesOf(const fs::path& file, StereoHalves stated, double aspect) {
    if (stated != StereoHalves::Automatic) return stated;
    const std::optional<SceneName> name = parseSceneName(file);
    if (name && name->halves != StereoHalves::Automatic) return name->halves;
    if (aspect <= 0) return StereoHalves::Automatic;
    const bool isSqueezed = squeezeOf(aspect, true, StereoHalves::Automatic) != Squeeze::None;
    return isSqueezed ? StereoHalves::Squeezed : StereoHalves::Full;
}

const std::vector<std::string>& imageExtensions() {
    static const std::vector<std::string> extensions = {
        ".png",  ".jpg",  ".jpeg", ".jpe", ".jfif", ".mpo",  ".jps", ".pns", ".tif",
        ".tiff", ".webp", ".bmp",  ".dib", ".pnm",  ".ppm",  ".pgm", ".pbm", ".pfm",
        ".exr",  ".hdr",  ".jp2",  ".j2k", ".heic", ".heif", ".hif", ".avif"};
    return extensions;
}

bool hasImageExtension(const fs::path& file) {
    const auto& known = imageExtensions();
    return std::find(known.begin(), known.end(), lowerExtension(file)) != known.end();
}

std::vector<fs::path> listImages(const fs::path& directory) {
    std::error_code error;
    if (fs::status(directory, error).type() == fs::file_type::not_found) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "does not exist, expected a directory with pictures");
    }
    std::vector<fs::path> pictures;
    fs::directory_iterator entries(directory, error); // error: why the directory cannot be read
    while (!error && entries != fs::directory_iterator()) {
        const fs::path& path = entries->path();
        const bool isHidden = path.filename().string().rfind('.', 0) == 0;
        std::error_code unreadable; // dangling links are left out
        if (!isHidden && entries->is_regular_file(unreadable) &&
            (hasImageExtension(path) || isNamelessPicture(path)))
            pictures.push_back(path);
        entries.increment(error);
    }
    if (error) {
        throw Error(ErrorCode::ReadFailed, directory.string(),
                    "cannot be listed: " + error.message() + ", expected a directory");
    }
    std::sort(pictures.begin(), pictures.end(), [](const fs::path& a, const fs::path& b) {
        return naturalLess(a.filename().string(), b.filename().string());
    });
    return pictures;
}

bool naturalLess(const std::string& a, const std::string& b) {
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size()) {
        if (!isDigit(a[i]) || !isDigit(b[j])) {
            const auto left = static_cast<unsigned char>(lowerCase(a[i]));
            const auto right = static_cast<unsigned char>(lowerCase(b[j]));
            if (left != right) return left < right;
            ++i;
            ++j;
            continue;
        }
        const auto digitsOf = [](std::string_view text, std::size_t& at) { // without zeros in front
            const std::size_t end = std::min(text.find_first_not_of(kDigits, at), text.size());
            const std::size_t begin = std::min(text.find_first_not_of('0', at), end);
            at = end;
            return text.substr(begin, end - begin);
        };
        const std::string_view left = digitsOf(a, i);
        const std::string_view right = digitsOf(b, j);
        if (left.size() != right.size()) return left.size() < right.size();
        if (left != right) return left < right;
    }
    if ((i == a.size()) != (j == b.size())) return i == a.size();
    return a < b; // differ only in case or leading zeros: a fixed order
}

fs::path photoOfDepthName(const fs::path& depth) {
    const std::string stem = depth.stem().string();
    for (const std::string_view word : kWords) {
        if (!endsWithWord(stem, word) || stem.size() < word.size() + 2) continue;
        const std::string photo = stem.substr(0, stem.size() - word.size() - 1);
        return endsWithWord(photo, kWith) ? fs::path() : depth.parent_path() / photo;
    }
    return {};
}

fs::path findDepthBeside(const fs::path& photo) {
    const fs::path directory = photo.parent_path();
    const std::string stem = photo.stem().string();
    if (stem.empty()) return {};
    const std::u32string comparable = comparableName(stem);
    fs::path best;
    fs::path alike;        // a picture with a comparable name
    bool isShared = false; // another photo has a comparable name
    std::error_code error;
    fs::directory_iterator entry(directory.empty() ? fs::path(".") : directory, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const fs::path name = entry->path().filename();
        if (!hasImageExtension(name)) continue;
        const std::string of = photoOfDepthName(name).string();
        const std::string other = of.empty() ? name.stem().string() : of;
        if (other != stem && comparableName(other) != comparable) continue;
        std::error_code unreadable; // dangling links are left out
        if (!entry->is_regular_file(unreadable)) continue;
        isShared = isShared || (of.empty() && other != stem);
        fs::path& found = other == stem ? best : alike;
        if (!of.empty() && (found.empty() || naturalLess(name.string(), found.string())))
            found = name;
    }
    if (best.empty() && !isShared) best = alike;
    return best.empty() ? fs::path() : directory / best;
}

} // namespace altiro3D
