// Pixels of a row by method Layered: LayeredReader.

#include "views/views_layered_reader.hpp"

#include "base/pixel_rows.hpp"

#include <cmath>
#include <cstring>
#include <numeric>

namespace altiro3D {

LayeredReader::LayeredReader(const cv::Mat& photo, const LayeredScene& scene,
                             const std::vector<int>& columns, std::size_t parts)
    : photo_(photo), scene_(scene), columns_(columns),
      columnPlaces_(paddedRow<float>(columns.size())),
      places_(paddedRow<std::int32_t>(columns.size())),
      room_(parts, std::min(columns.size(), kPixelsAtATime)) {
    for (std::vector<float>* values : copies_.all())
        *values = columnPlaces_;
    for (std::vector<std::int16_t>* values : lines_.all())
        *values = paddedRow<std::int16_t>(columns.size()); // the padding is a line that never moves
    lines_.from = lines_.to = std::vector<std::int16_t>(columns.size() + kRowPadding, INT16_MAX);
    isWholeRow_ = static_cast<int>(columns.size()) == scene.width;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        if (columns[i] != static_cast<int>(i)) isWholeRow_ = false;
        columnPlaces_[i] = static_cast<float>(columns[i]);
        places_[i] = columns[i] << kSubColumnBits;
    }
}

void LayeredReader::open(int row) {
    row_ = row;
    if (still()) return;
    tables_ = scene_.tables(row);
    layeredColumns(tables_, scratch_, known_);
    for (std::size_t i = 0; i < lines_.all().size(); ++i)
        pickColumns(columns_.data(), columns_.size(), known_.lines.all()[i]->data(),
                    lines_.all()[i]->data());
    isPicked_ = isWholeRow_;
    listSurfaces();
    splitPlanes();
    soft_.open(scene_, row, tables_, strips_);
}

void LayeredReader::read(std::size_t part, int channel, std::uint8_t* values) const {
    const std::uint8_t* plane = planes_[static_cast<std::size_t>(channel)].data() + kTablePadding;
    const std::size_t first = part * room_.stride;
    layeredSamples(plane, room_.places.data() + first, size(), values);
    const auto set = [](std::uint8_t& value, int to) { value = static_cast<std::uint8_t>(to); };
    for (std::size_t i = behindStarts_[part]; i < behindStarts_[part + 1]; ++i) {
        std::uint8_t& value = values[behind_[i].pixel];
        set(value, behind_[i].colour(value, plane));
    }
    const bool anySoft = soft_.any();
    for (const auto* i = mixedOrder_.begin(part); i < mixedOrder_.end(part); ++i) {
        std::uint8_t& value = values[static_cast<std::size_t>(room_.mixed[*i]) - first];
        int cover = sampleAt(plane, room_.covers[*i]);
        if (anySoft) cover = behindCovers_[*i].colour(cover, plane);
        set(value, coveredBy(cover, value, room_.shares[*i]));
    }
    for (const auto* i = hardOrder_.begin(part); i < hardOrder_.end(part); ++i) {
        const LayeredPixel& pixel = hard_[*i];
        const auto coverOf = [&](int k) {
            const int cover = sampleAt(plane, pixel.place[k]);
            return anySoft ? behindHard_[*i][static_cast<std::size_t>(k)].colour(cover, plane)
                           : cover;
        };
        set(values[static_cast<std::size_t>(room_.hard.pixels[*i]) - first],
            colourOf(pixel, coverOf));
    }
}

void LayeredReader::PartOrder::sort(const std::vector<std::int32_t>& pixels, std::size_t count,
                                    std::size_t parts, std::size_t stride) {
    starts_.assign(parts + 2, 0); // each at first one further than at last
    order_.resize(count);
    const auto partOf = [&](std::size_t i) {
        return static_cast<std::uint32_t>(pixels[i]) / static_cast<std::uint32_t>(stride);
    };
    for (std::size_t i = 0; i < count; ++i)
        ++starts_[partOf(i) + 2];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    for (std::size_t i = 0; i < count; ++i)
        order_[starts_[partOf(i) + 1]++] = i;
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

LayeredPixels LayeredReader::pixels(std::size_t part) const {
    const LayeredColumns& values = isWholeRow_ ? known_ : copies_;
    return {columnPlaces_.data() + begin_,
            values.offsets.data() + begin_,
            values.slopes.data() + begin_,
            values.from.data() + begin_,
            values.to.data() + begin_,
            values.first.data() + begin_,
            values.mirroredFirst.data() + begin_,
            room_.openBlocks(part),
            size()};
}

void LayeredReader::guess(std::size_t part, LayeredOpenCounts& open) {
    if (!isPicked_) {
        for (std::size_t i = 0; i < known_.all().size(); ++i)
            pickColumns(columns_.data(), columns_.size(), known_.all()[i]->data(),
                        copies_.all()[i]->data());
        isPicked_ = true;
    }
    layeredGuesses(tables_, pixels(part), room_.shifts.data(), part * room_.stride,
                   room_.pointers(), open);
}

LayeredOpenCounts LayeredReader::listAll(const float* shifts) {
    LayeredOpenCounts open;
    for (std::size_t i = 0; i < size(); ++i) {
        const float shift = shifts[begin_ + i];
        const std::size_t direction = shift < 0 ? 1 : 0;
        const std::size_t entry = open.size[direction]++;
        Room::List& list = room_.open[direction];
        list.pixels[entry] = static_cast<std::int32_t>(i);
        list.columns[entry] = columnPlaces_[begin_ + i];
        list.shifts[entry] = shift;
    }
    return open;
}

void LayeredReader::findEnds(const LayeredOpenCounts& open, std::size_t parts) {
    counts_ = {};
    const LayeredSurfaces surfaces = {left_.data(),
                                      right_.data(),
                                      endOffsets_.data(),
                                      {0, mirroredSurfaces_, static_cast<int>(left_.size())}};
    const LayeredRoom room = room_.pointers();
    for (int direction = 0; direction < 2; ++direction) {
        const std::size_t size = open.size[direction];
        if (bounded_ && scene_.inOrder) {
            layeredAmongSurfaces(tables_, surfaces, scene_.reachColumns, direction, size, room,
                                 counts_);
        } else {
            leaveToSearch(room.open[direction], size, direction);
        }
    }
    const LayeredSearch search(scene_, row_, tables_, strips_);
    hard_.resize(counts_.hard);
    for (std::size_t i = 0; i < counts_.hard; ++i) {
        const int column = static_cast<int>(room_.hard.columns[i]);
        const float shift = room_.hard.shifts[i];
        const int direction = shift < 0 ? 1 : 0;
        const int x = direction == 0 ? column : scene_.width - 1 - column;
        hard_[i] = search.at(direction, x, std::abs(shift), room_.hardColumns[i]);
    }
    mixedOrder_.sort(room_.mixed, counts_.mixed, parts, room_.stride);
    hardOrder_.sort(room_.hard.pixels, counts_.hard, parts, room_.stride);
}

void LayeredReader::leaveToSearch(const LayeredList& list, std::size_t size, int direction) {
    const int last = scene_.width - 1;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t entry = counts_.hard++;
        const int column = static_cast<int>(list.columns[i]);
        const int x = direction == 0 ? column : last - column;
        room_.places[static_cast<std::size_t>(list.pixels[i])] = kSeeEnds;
        room_.hard.pixels[entry] = list.pixels[i];
        room_.hard.columns[entry] = list.columns[i];
        room_.hard.shifts[entry] = list.shifts[i];
        room_.hardColumns[entry] = bounded_ ? std::min(x + scene_.reachColumns, last) : last;
    }
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
