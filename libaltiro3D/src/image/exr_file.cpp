#include "image/exr_file.hpp"

#include "base/checks.hpp"
#include "base/image_format.hpp"

#include <algorithm>
#include <map>

namespace altiro3D {

namespace {

// "ViewLayer.Depth.Z": "ViewLayer.Depth", "depth" and "z"
struct NameParts {
    explicit NameParts(const std::string& full) {
        const std::size_t dot = full.rfind('.');
        if (dot != std::string::npos) layer = full.substr(0, dot);
        base = lowerCase(full.substr(dot + 1));
        pass = lowerCase(layer.substr(layer.rfind('.') + 1));
    }
    std::string layer;
    std::string pass;
    std::string base;
};

template <class... Text>
bool isOneOf(const std::string& text, const Text&... others) {
    return ((text == others) || ...);
}

// A rank: the smaller it is, the more surely the channel holds distances.
int distanceRank(const NameParts& name, bool isOfVector) {
    constexpr int kNone = 100;
    if (isOfVector) return kNone; // positions and normals: X, Y, Z
    if (name.base == "z" && name.layer.empty()) return 0;
    const bool isDepth = name.pass.find("depth") != std::string::npos;
    if (isDepth && isOneOf(name.base, "z", "v", "y", "r", "depth")) return 1;
    if (isOneOf(name.base, "depth", "zdepth", "distance")) return 2;
    return name.base == "z" ? 3 : kNone;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
        text += (i > 0 ? ", " : "") + names[i];
    return text + (names.size() > kMost ? ", ..." : "");
}

// Candidates by rank: a smaller one is more certain. Those of one rank are in the file's order.
using Ranked = std::multimap<int, std::vector<ExrChannel>>;

ExrChoice firstOf(const Ranked& found) {
    ExrChoice choice;
    for (const auto& [rank, channels] : found) {
        if (choice.channels.empty())
            choice.channels = channels;
        else
            choice.others.push_back(channels.back().full);
    }
    return choice;
}

// Converts failures of OpenEXR, whose library is loaded separately.
template <class Work>
auto orPictureFailure(const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& exception) {
        throw PictureFailure(std::string("OpenEXR: ") + exception.what());
    }
}

} // namespace

ExrChoice chooseExrColours(const std::vector<ExrChannel>& channels) {
    using Layer = std::map<std::string, const ExrChannel*>;
    std::map<std::pair<int, std::string>, Layer> layers;
    for (const ExrChannel& channel : channels) {
        const NameParts name(channel.full);
        if (distanceRank(name, false) == 1) continue; // Depth.R
        layers[{channel.part, name.layer}][name.base] = &channel;
    }
    Ranked found;
    for (const auto& [key, layer] : layers) {
        const auto has = [&layer = layer](const char* base) { return layer.count(base) > 0; };
        const std::string pass = NameParts(key.second + ".r").pass;
        const int rank = key.second.empty()                            ? 0
                         : isOneOf(pass, "combined", "beauty", "rgba") ? 1
                                                                       : 2;
        if (has("r") && has("g") && has("b")) {
            std::vector<ExrChannel> colours{*layer.at("b"), *layer.at("g"), *layer.at("r")};
            if (has("a")) colours.push_back(*layer.at("a"));
            found.emplace(rank, colours);
        } else if (has("y") && !has("x")) {
            found.emplace(3 + rank, std::vector<ExrChannel>{*layer.at("y")});
        }
    }
    return firstOf(found);
}

ExrChoice chooseExrDistance(const std::vector<ExrChannel>& channels) {
    Ranked found;
    for (const ExrChannel& channel : channels) {
        const NameParts name(channel.full);
        const bool isOfVector =
            name.base.size() == 1 &&
            std::any_of(channels.begin(), channels.end(), [&](const ExrChannel& other) {
                const NameParts others(other.full);
                return other.part == channel.part && others.layer == name.layer &&
                       others.base == "x";
            });
        const int rank = distanceRank(name, isOfVector);
        if (rank < 10) found.emplace(rank, std::vector<ExrChannel>{channel});
    }
    return firstOf(found);
}

std::vector<ExrChannel> exrChannels(std::string_view bytes) {
    auto* const read = openCvCodecs().exrChannels;
    if (read == nullptr) return {};
    auto channels = orPictureFailure([&] { return read(bytes); });
    if (channels.empty())
        throw PictureFailure("it holds deep data or subsampled colours, which are not read");
    return channels;
}

cv::Mat readExr(std::string_view bytes, const std::vector<ExrChannel>& channels) {
    return orPictureFailure([&] { return openCvCodecs().readExr(bytes, channels); });
}

void addExrNotes(const ExrChoice& choice, const char* what, Notes* notes) {
    if (choice.others.empty()) return;
    addNote(notes, NoteCode::LeftOut,
            std::string("several of its channels may be ") + what + ": " +
                choice.channels.back().full + " is read, and not " + listed(choice.others));
}

cv::Mat decodeExr(std::string_view bytes, bool asDepth, Notes* notes) {
    if (openCvCodecs().exrChannels == nullptr) return {};
    const std::vector<ExrChannel> channels = exrChannels(bytes);
    const ExrChoice distance = chooseExrDistance(channels);
    ExrChoice choice = asDepth ? distance : ExrChoice();
    const bool isDistance = !choice.channels.empty();
    if (!isDistance) choice = chooseExrColours(channels);
    const bool isNamed = distance.channels.empty() || asDepth;
    if (choice.channels.empty() && channels.size() == 1 && isNamed) choice.channels = channels;
    if (choice.channels.empty()) {
        std::vector<std::string> names;
        for (const ExrChannel& channel : channels)
            names.push_back(channel.full);
        throw PictureFailure(
            "its channels are " + listed(names) +
            (asDepth ? "; of these, none is named as depth, such as Z or Depth.Z"
                     : "; of these, none are colours, such as R, G and B; if it is depth, give it "
                       "with its photo"));
    }
    if (isDistance || !asDepth) addExrNotes(choice, isDistance ? "depth" : "the picture", notes);
    return readExr(bytes, choice.channels);
}

std::string exrDistanceOf(const PhotoFile& file) {
    if (imageFormat(file.start(16)) != ImageFormat::Exr) return {};
    const std::string_view bytes = file.look();
    try {
        const ExrChoice choice = chooseExrDistance(exrChannels(bytes));
        return choice.channels.empty() ? std::string() : choice.channels.front().full;
    } catch (const PictureFailure&) { // the decoder says it
        return {};
    }
}

} // namespace altiro3D
