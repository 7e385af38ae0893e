// Shows a Native on the light-field display, or in a window if none is connected.

#include <QApplication>
#include <QScreen>
#include <altiro3D/altiro3D.hpp>
#include <altiro3D/qt/display_search.hpp>
#include <altiro3D/qt/native_widget.hpp>
#include <iostream>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const QApplication application(argc, argv);
    try {
        const cv::Mat native = altiro3D::readPhoto(argv[1]);
        std::vector<altiro3D::qt::ScreenFacts> screens;
        for (const QScreen* screen : QGuiApplication::screens())
            screens.push_back(altiro3D::qt::factsOf(*screen));
        const auto displays = altiro3D::qt::findDisplays(screens, altiro3D::qt::findVolumes());
        const auto chosen =
            altiro3D::qt::chooseDisplay(displays, screens, std::nullopt, native.size());

        altiro3D::qt::NativeWidget widget;
        QObject::connect(&widget, &altiro3D::qt::NativeWidget::left, &QApplication::quit);
        widget.setNative(native);
        if (chosen)
            widget.showOn(*QGuiApplication::screens()[int(*displays[*chosen].screen)]);
        else
            widget.show();
        return QApplication::exec();
    } catch (const altiro3D::Error& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
