// Pixels of a row by method Layered: LayeredReader.

#include "views/layered/layered_reader.hpp"

#include "base/pixel_rows.hpp"

#include <cmath>
#include <cstring>

namespace altiro3D {

LayeredReader::LayeredReader(const cv::Mat& photo, const LayeredScene& scene,
                             const std::vector<int>& columns,
                             const std::vector<std::uint8_t>& parts)
    : photo_(photo), scene_(scene), columns_(columns), parts_(parts),
      columnPlaces_(paddedRow<float>(columns.size())),
      places_(paddedRow<std::int32_t>(columns.size())),
      room_(std::min(columns.size(), kPixelsAtATime)), softPixels_(room_.places.size()) {
    for (std::vector<float>* values : copies_.all())
        *values = columnPlaces_;
    for (std::vector<std::int16_t>* values : lines_.all())
        *values = paddedRow<std::int16_t>(columns.size()); // the padding is a line that never moves
    lines_.from = lines_.to = std::vector<std::int16_t>(columns.size() + kRowPadding, INT16_MAX);
    isWholeRow_ = static_cast<int>(columns.size()) == scene.width;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        if (columns[i] != static_cast<int>(i)) isWholeRow_ = false;
        places_[i] = (columns[i] << kSubColumnBits) + (parts.empty() ? 0 : parts[i]);
        columnPlaces_[i] = static_cast<float>(places_[i]) / (1 << kSubColumnBits);
    }
    if (std::all_of(parts.begin(), parts.end(), [](std::uint8_t part) { return part == 0; }))
        parts_.clear();
    if (!parts_.empty()) isWholeRow_ = false;
}

void LayeredReader::open(int row) {
    row_ = row;
    if (still()) return;
    tables_ = scene_.tables(row);
    layeredColumns(tables_, scratch_, known_);
    if (!parts_.empty()) joinColumns();
    for (std::size_t i = 0; i < lines_.all().size(); ++i)
        pickColumns(columns_.data(), columns_.size(), known_.lines.all()[i]->data(),
                    lines_.all()[i]->data());
    for (std::size_t i = 0; i < parts_.size(); ++i) // 1/32768 px per column to 1/512 px
        lines_.offsets[i] = static_cast<std::int16_t>(
            lines_.offsets[i] + lines_.slopes[i] * parts_[i] / (64 << kSubColumnBits));
    isPicked_ = isWholeRow_;
    listSurfaces();
    splitPlanes();
    soft_.open(scene_, row, tables_, strips_);
}

void LayeredReader::joinColumns() {
    const auto join = [&](auto& limits, auto none) {
        for (std::size_t x = 0; x + 1 < static_cast<std::size_t>(scene_.width); ++x) {
            const auto least =
                none < 0 ? std::min(limits[x], limits[x + 1]) : std::max(limits[x], limits[x + 1]);
            limits[x] = known_.first[x] == known_.first[x + 1] ? least : none;
        }
    };
    join(known_.from, 1.0F);
    join(known_.to, -1.0F);
    join(known_.lines.from, -1);
    join(known_.lines.to, -1);
}

void LayeredReader::read(int channel, std::uint8_t* values) const {
    const std::uint8_t* plane = planes_[static_cast<std::size_t>(channel)].data() + kTablePadding;
    layeredSamples(plane, room_.places.data(), size(), values);
    const auto set = [&](std::int32_t pixel, int to) {
        values[pixel] = static_cast<std::uint8_t>(to);
    };
    for (const SoftPixel& behind : behind_)
        set(behind.pixel, behind.colour(values[behind.pixel], plane));
    const bool anySoft = soft_.any();
    for (std::size_t i = 0; i < room_.mixedCount; ++i) {
        int cover = sampleAt(plane, room_.covers[i]);
        if (anySoft) cover = behindCovers_[i].colour(cover, plane);
        set(room_.mixed[i], coveredBy(cover, values[room_.mixed[i]], room_.parts[i]));
    }
    for (std::size_t i = 0; i < hard_.size(); ++i) {
        const auto coverOf = [&](int k) {
            const int cover = sampleAt(plane, hard_[i].place[k]);
            return anySoft ? behindHard_[i][static_cast<std::size_t>(k)].colour(cover, plane)
                           : cover;
        };
        set(room_.hard.pixels[i], colourOf(hard_[i], coverOf));
    }
}

LayeredLinePixels LayeredReader::linePixels(const std::int16_t* shifts) const {
    return {lines_.offsets.data() + begin_,
            lines_.slopes.data() + begin_,
            lines_.from.data() + begin_,
            lines_.to.data() + begin_,
            places_.data() + begin_,
            shifts + begin_,
            scene_.reachPixels,
            size()};
}

LayeredPixels LayeredReader::pixels() const {
    const LayeredColumns& values = isWholeRow_ ? known_ : copies_;
    return {columnPlaces_.data() + begin_,
            values.offsets.data() + begin_,
            values.slopes.data() + begin_,
            values.from.data() + begin_,
            values.to.data() + begin_,
            values.first.data() + begin_,
            values.mirroredFirst.data() + begin_,
            size()};
}

void LayeredReader::clearLists() {
    for (LayeredList* list : {&room_.open[0], &room_.open[1], &room_.hard})
        list->size = 0;
    room_.mixedCount = 0;
}

void LayeredReader::guess() {
    if (!isPicked_) {
        for (std::size_t i = 0; i < known_.all().size(); ++i)
            pickColumns(columns_.data(), columns_.size(), known_.all()[i]->data(),
                        copies_.all()[i]->data());
        isPicked_ = true;
    }
    layeredGuesses(tables_, pixels(), room_);
}

void LayeredReader::listAll(const float* shifts) {
    std::fill(room_.openBlocks.begin(), room_.openBlocks.end(), std::uint8_t{1});
    std::copy_n(shifts, size(), room_.shifts.begin());
    for (std::size_t i = 0; i < size(); ++i) {
        LayeredList& list = room_.open[shifts[i] < 0 ? 1 : 0];
        list.pixels[list.size] = static_cast<std::int32_t>(i);
        list.columns[list.size] = columnPlaces_[begin_ + i];
        list.shifts[list.size] = shifts[i];
        ++list.size;
    }
}

void LayeredReader::findEnds() {
    const LayeredSurfaces surfaces = {left_.data(),
                                      right_.data(),
                                      endOffsets_.data(),
                                      {0, mirroredSurfaces_, static_cast<int>(left_.size())}};
    for (int direction = 0; direction < 2; ++direction) {
        if (bounded_ && scene_.inOrder) {
            layeredAmongSurfaces(tables_, surfaces, scene_.reachColumns, direction, room_);
        } else {
            leaveToSearch(direction);
        }
    }
    const LayeredSearch search(scene_, row_, tables_, strips_);
    hard_.resize(room_.hard.size);
    for (std::size_t i = 0; i < hard_.size(); ++i) {
        const float column = room_.hard.columns[i];
        const float shift = room_.hard.shifts[i];
        const int direction = shift < 0 ? 1 : 0;
        const float x = direction == 0 ? column : static_cast<float>(scene_.width - 1) - column;
        hard_[i] = search.at(direction, x, std::abs(shift), room_.hardColumns[i]);
    }
    findBehind();
}

void LayeredReader::leaveToSearch(int direction) {
    const LayeredList& list = room_.open[direction];
    LayeredList& hard = room_.hard;
    const int last = scene_.width - 1;
    for (std::size_t i = 0; i < list.size; ++i) {
        const float column = list.columns[i];
        const int x = static_cast<int>(
            std::ceil(direction == 0 ? column : static_cast<float>(last) - column));
        room_.places[static_cast<std::size_t>(list.pixels[i])] = kSeeEnds;
        hard.pixels[hard.size] = list.pixels[i];
        hard.columns[hard.size] = list.columns[i];
        hard.shifts[hard.size] = list.shifts[i];
        room_.hardColumns[hard.size] = bounded_ ? std::min(x + scene_.reachColumns, last) : last;
        ++hard.size;
    }
}

void LayeredReader::findBehind() {
    behind_.clear();
    if (!soft_.any()) return;
    const auto at = [&](std::int32_t pixel, std::int32_t place) {
        const auto i = static_cast<std::size_t>(pixel);
        SoftPixel soft = soft_.at(place, places_[begin_ + i], room_.shifts[i]);
        soft.pixel = pixel;
        return soft;
    };
    const std::size_t count = soft_.find(room_, size(), softPixels_.data());
    for (std::size_t i = 0; i < count; ++i) {
        const std::int32_t pixel = softPixels_[i];
        behind_.push_back(at(pixel, room_.places[static_cast<std::size_t>(pixel)]));
    }
    behindCovers_.resize(room_.mixedCount);
    for (std::size_t i = 0; i < room_.mixedCount; ++i)
        behindCovers_[i] = at(room_.mixed[i], room_.covers[i]);
    behindHard_.resize(hard_.size());
    for (std::size_t i = 0; i < hard_.size(); ++i)
        for (int k = 0; k < hard_[i].count; ++k)
            behindHard_[i][static_cast<std::size_t>(k)] =
                at(room_.hard.pixels[i], hard_[i].place[k]);
}

void LayeredReader::listSurfaces() {
    constexpr float kNoBorder = -1e9F;
    const LayeredRow* rows[] = {&scene_.rows[0][static_cast<std::size_t>(row_)],
                                &scene_.rows[1][static_cast<std::size_t>(row_)]};
    strips_[0] = 2 * scene_.stride();
    strips_[1] = strips_[0] + static_cast<int>(rows[0]->strips.size() / 4);
    mirroredSurfaces_ = static_cast<int>(rows[0]->surfaces.size());
    left_.clear();
    right_.clear();
    endOffsets_.clear();
    for (int direction = 0; direction < 2; ++direction) {
        const std::size_t begin = left_.size();
        for (const LayeredSurface& surface : rows[direction]->surfaces) {
            const auto strip = static_cast<float>(strips_[direction] + surface.hiddenAt(0));
            left_.push_back({static_cast<float>(surface.first), static_cast<float>(surface.hidden),
                             surface.hidden > 0 ? kNoBorder : 1 + surface.leftExtra, strip});
            // without a strip to its right, its last column is that of the photo, which may be soft
            const int plain = direction == 0 ? surface.last : scene_.width - 1 - surface.last;
            right_.push_back({static_cast<float>(surface.last), static_cast<float>(surface.beyond),
                              1 + surface.rightExtra,
                              surface.beyond > 0 ? strip : static_cast<float>(plain - 1)});
            const auto offsetAt = [&](int column) {
                const std::int16_t* words = tables_.words + direction * tables_.stride;
                return static_cast<float>(wordOffset(words[column])) * 0x1p18F;
            };
            endOffsets_.push_back({offsetAt(surface.first), offsetAt(surface.last)});
            endOffsets_.back().passing = passing(begin);
        }
    }
}

float LayeredReader::passing(std::size_t begin) const {
    constexpr float kRounding = 0.01F; // px
    const float last = right_.back().column;
    const float offset = endOffsets_.back().last;
    // what is farther away does not come into the gap within the reach
    const float farthest = last - static_cast<float>(2 * scene_.reachColumns + kEndReach);
    float least = kNeverPasses;
    for (std::size_t i = right_.size() - 1; i-- > begin && right_[i].column >= farthest;) {
        const float nearer = offset - endOffsets_[i].last;
        const float way = last - right_[i].column - right_[i].painted - right_[i].border;
        if (nearer > 0) least = std::min(least, std::max(way - kRounding, 0.0F) / nearer);
    }
    return least;
}

void LayeredReader::splitPlanes() {
    const auto width = static_cast<std::size_t>(scene_.width);
    const LayeredRow* rows[] = {&scene_.rows[0][static_cast<std::size_t>(row_)],
                                &scene_.rows[1][static_cast<std::size_t>(row_)]};
    const std::size_t painted = (rows[0]->strips.size() + rows[1]->strips.size()) / 4;
    const std::size_t size =
        kTablePadding + 2 * static_cast<std::size_t>(scene_.stride()) + painted + kRowPadding;
    for (std::vector<std::uint8_t>& plane : planes_)
        plane.resize(std::max(plane.size(), size));
    splitRow(bgr(), width, planes_[0].data() + kTablePadding, planes_[1].data() + kTablePadding,
             planes_[2].data() + kTablePadding);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        std::uint8_t* row = planes_[channel].data() + kTablePadding;
        std::uint8_t* mirrored = row + scene_.stride();
        std::reverse_copy(row, row + width, mirrored);
        for (std::uint8_t* begin : {row, mirrored}) {
            std::memset(begin - kTablePadding, begin[0], kTablePadding);
            std::memset(begin + width, begin[width - 1], kTablePadding);
        }
        for (int direction = 0; direction < 2; ++direction) {
            const std::vector<std::uint8_t>& strips = rows[direction]->strips;
            std::uint8_t* to = row + strips_[direction];
            for (std::size_t i = channel; i < strips.size(); i += 4)
                *to++ = strips[i];
        }
    }
}

} // namespace altiro3D
