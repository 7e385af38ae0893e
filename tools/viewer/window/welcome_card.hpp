#pragma once

#include <QFrame>
#include <filesystem>
#include <optional>

class QLabel;

namespace altiro3D::viewer {

/// What a new user sees above the sample photo: what can be done, or which display was found.
class WelcomeCard : public QFrame {
    Q_OBJECT
  public:
    explicit WelcomeCard(QWidget* parent = nullptr);

    /// @param display name of the display that was found; empty: none
    void greet(const QString& display);

  signals:
    void openWanted();
    void closed(); ///< By its button.

  private:
    QLabel* headline_;
    QLabel* advice_;
};

/// The sample photo, installed or in the source tree; nothing if it is missing.
std::optional<std::filesystem::path> samplePhoto();

} // namespace altiro3D::viewer
