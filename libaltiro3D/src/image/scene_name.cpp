// What file names say of both eyes, depth and VR: parseSceneName() of image_io.hpp.

#include "altiro3D/image_io.hpp"
#include "base/text.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <cctype>
#include <set>
#include <system_error>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

struct EyesTag {
    const char* word;
    StereoLayout layout;
    StereoHalves halves;
};

constexpr EyesTag kEyesTags[] = {
    {"lr", StereoLayout::LeftRight, StereoHalves::Automatic},
    {"sbs", StereoLayout::LeftRight, StereoHalves::Automatic},
    {"2x1", StereoLayout::LeftRight, StereoHalves::Automatic},
    {"3dh", StereoLayout::LeftRight, StereoHalves::Automatic},
    {"3dph", StereoLayout::LeftRight, StereoHalves::Automatic},
    {"hsbs", StereoLayout::LeftRight, StereoHalves::Squeezed},
    {"lrf", StereoLayout::LeftRight, StereoHalves::Full},
    {"fsbs", StereoLayout::LeftRight, StereoHalves::Full},
    {"fullsbs", StereoLayout::LeftRight, StereoHalves::Full},
    {"3dhf", StereoLayout::LeftRight, StereoHalves::Full},
    {"3dphf", StereoLayout::LeftRight, StereoHalves::Full},
    {"rl", StereoLayout::RightLeft, StereoHalves::Automatic},
    {"cross", StereoLayout::RightLeft, StereoHalves::Automatic},
    {"rlf", StereoLayout::RightLeft, StereoHalves::Full},
    {"tb", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"tab", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"ou", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"1x2", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"3dv", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"3dpv", StereoLayout::TopBottom, StereoHalves::Automatic},
    {"htb", StereoLayout::TopBottom, StereoHalves::Squeezed},
    {"htab", StereoLayout::TopBottom, StereoHalves::Squeezed},
    {"hou", StereoLayout::TopBottom, StereoHalves::Squeezed},
    {"tbf", StereoLayout::TopBottom, StereoHalves::Full},
    {"fulltb", StereoLayout::TopBottom, StereoHalves::Full},
    {"3dvf", StereoLayout::TopBottom, StereoHalves::Full},
    {"3dpvf", StereoLayout::TopBottom, StereoHalves::Full},
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
            other.compare(other.size() - after.size(), after.size(), after) != 0)
            continue;
        const std::string number =
            other.substr(before.size(), other.size() - before.size() - after.size());
        const bool isNumber =
            std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
        if (isNumber && number != "180" && number != "360") return true;
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
        for (const EyesTag& tag : kEyesTags) {
            if (word.lower != tag.word) continue;
            eyes = SceneName{SceneName::Contents::Eyes, word.text, tag.layout, false, tag.halves};
            if (words[i - 1].lower == "full") eyes->halves = StereoHalves::Full;
            if (words[i - 1].lower == "half") eyes->halves = StereoHalves::Squeezed;
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

} // namespace altiro3D
