#pragma once

#include "support/files.hpp"
#include "support/onnx.hpp"

#include <QCryptographicHash>
#include <filesystem>
#include <string>

namespace altiro3D::test {

/// Writes a catalogue that knows one network, "tiny" of 32 x 32 px: bright is near.
inline void writeTinyNetwork(const std::filesystem::path& folder) {
    const std::string file = onnx::mixModel({0.2F, 0.3F, 0.5F}, {0, 0});
    QCryptographicHash hash(QCryptographicHash::Sha256);
    hash.addData(file.data(), static_cast<int>(file.size()));
    spill(folder / "tiny.onnx", file);
    spill(folder / "catalog.json",
          R"({"networks": [{"name": "tiny", "file": "tiny.onnx", "inputWidth": 32,)"
          R"( "inputHeight": 32, "sha256": ")" +
              hash.result().toHex().toStdString() + R"("}]})");
}

} // namespace altiro3D::test
