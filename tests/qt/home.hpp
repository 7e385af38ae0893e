#pragma once

#include "support/tiny_network.hpp"

#include <QTemporaryDir>

namespace altiro3D::test {

/// A separate home directory while the object exists: the tests do not read the user's settings,
/// caches and depth networks; there is a tiny one.
class Home {
  public:
    Home() {
        const QByteArray path = directory_.path().toUtf8();
        for (const char* name :
             {"XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "ALTIRO3D_MODELS"})
            qputenv(name, path);
        writeTinyNetwork(path.toStdString());
    }

  private:
    QTemporaryDir directory_;
};

} // namespace altiro3D::test
