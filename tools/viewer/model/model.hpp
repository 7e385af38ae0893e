#pragma once

#include "viewer/model/exports.hpp"

namespace altiro3D::viewer {

/// The viewer without its window.
///
/// Used from one thread, which it never blocks: workers read files, make pictures and export. It
/// can be destroyed at any time.
struct Model {
    /// @param display the display that Natives are made for
    explicit Model(Display display)
        : files(std::move(display), settings), stage(files, settings),
          exports(files, settings, stage) {}

    Settings settings;
    Files files;
    Stage stage;
    Exports exports;
};

} // namespace altiro3D::viewer
