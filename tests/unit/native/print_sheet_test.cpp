#include "altiro3D/print_sheet.hpp"

#include "altiro3D/file_io.hpp"
#include "altiro3D/lens_sheet.hpp"
#include "altiro3D/lens_view.hpp"
#include "altiro3D/native_maker.hpp"
#include "image/row_file.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"

#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <tiffio.h>
#include <zlib.h>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

LensNumbers numbersOf(double lpi, double dpi, double width, double height) {
    LensNumbers numbers;
    numbers.lpi = lpi;
    numbers.dpi = dpi;
    numbers.width = width;
    numbers.height = height;
    return numbers;
}

Display printOf(double lpi, double dpi, double width, double height) {
    return displayOf(calibrationOf(numbersOf(lpi, dpi, width, height)));
}

void writeRows(const fs::path& file, const cv::Mat& picture, int atATime) {
    RowFile out(file, picture.size(), picture.type(), {720, 360});
    for (int y = 0; y < picture.rows; y += atATime)
        out.write(picture.rowRange(y, std::min(y + atATime, picture.rows)));
    out.finish();
}

TEST(RowFile, OtherProgramsReadWhatWasWritten) {
    const TemporaryDirectory folder;
    for (const char* name : {"a.png", "a.tif"}) {
        for (const int type : {CV_8UC1, CV_8UC3}) {
            for (const cv::Size size : {cv::Size(1, 1), cv::Size(601, 907), cv::Size(1100, 1201)}) {
                const cv::Mat picture = randomPicture(size, type);
                writeRows(folder / name, picture, 97);
                EXPECT_TRUE(samePicture(cv::imread((folder / name).string(), cv::IMREAD_UNCHANGED),
                                        picture))
                    << name << ", " << type << ", " << size;
            }
        }
    }
}

TEST(RowFile, BytesDoNotDependOnTheBands) {
    ALTIRO3D_TAKES(2);
    const TemporaryDirectory folder;
    const cv::Mat picture = randomPicture({1100, 1201}, CV_8UC3);
    for (const char* name : {"a.png", "a.tif", "a.pdf"}) {
        writeRows(folder / name, picture, 64);
        const std::string bytes = slurp(folder / name);
        writeRows(folder / name, picture, 1201);
        EXPECT_TRUE(slurp(folder / name) == bytes) << name;
    }
}

TEST(RowFile, HasAPhysicalSize) {
    const TemporaryDirectory folder;
    const cv::Mat picture = randomPicture({64, 48}, CV_8UC3);
    writeRows(folder / "a.png", picture, 48);
    const std::string png = slurp(folder / "a.png");
    const std::size_t chunk = png.find("pHYs");
    ASSERT_NE(chunk, std::string::npos);
    EXPECT_EQ(bigEndianAt(png, chunk + 4), 28346U); // 720 / 0.0254
    EXPECT_EQ(bigEndianAt(png, chunk + 8), 14173U);
    EXPECT_EQ(png.at(chunk + 12), 1);
    EXPECT_TRUE(holds(png, "sRGB"));

    writeRows(folder / "a.tif", picture, 48);
    TIFF* const tiff = TIFFOpen((folder / "a.tif").string().c_str(), "r");
    ASSERT_NE(tiff, nullptr);
    float across = 0;
    float down = 0;
    std::uint16_t unit = 0;
    std::uint16_t compression = 0;
    std::uint32_t length = 0;
    void* profile = nullptr;
    TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &across);
    TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &down);
    TIFFGetField(tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
    TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression);
    EXPECT_EQ(TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &length, &profile), 1);
    EXPECT_EQ(across, 720);
    EXPECT_EQ(down, 360);
    EXPECT_EQ(unit, RESUNIT_INCH);
    EXPECT_EQ(compression, COMPRESSION_ADOBE_DEFLATE);
    cmsHPROFILE icc = cmsOpenProfileFromMem(profile, length);
    ASSERT_NE(icc, nullptr);
    char name[64] = {};
    cmsGetProfileInfoASCII(icc, cmsInfoDescription, "en", "US", name, sizeof name);
    EXPECT_TRUE(holds(name, "sRGB"));
    cmsCloseProfile(icc);
    TIFFClose(tiff);
}

// The rows of a PDF's picture are those of a PNG: a filter's number and 3 bytes a px.
TEST(RowFile, PdfHasOnePageOfExactSize) {
    const TemporaryDirectory folder;
    writeRows(folder / "a.pdf", cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, 30)), 48);
    const std::string pdf = slurp(folder / "a.pdf");
    EXPECT_TRUE(holds(pdf, "/MediaBox [0 0 6.4 9.6]")); // 64 / 720 and 48 / 360 inches
    const std::size_t table = pdf.find("xref\n0 8\n");
    ASSERT_NE(table, std::string::npos);
    EXPECT_TRUE(holds(pdf, "startxref\n" + std::to_string(table) + "\n%%EOF"));
    for (int i = 1; i <= 7; ++i) {
        const auto at = std::stoul(pdf.substr(table + 9 + 20 * static_cast<std::size_t>(i), 10));
        const std::string object = std::to_string(i) + " 0 obj";
        EXPECT_EQ(pdf.substr(at, object.size()), object);
    }
    const std::size_t from = pdf.find("stream\n", pdf.find("/Predictor 15")) + 7;
    std::vector<unsigned char> rows(48 * (1 + 3 * 64) + 1);
    uLongf size = static_cast<uLongf>(rows.size());
    ASSERT_EQ(uncompress(rows.data(), &size, reinterpret_cast<const Bytef*>(pdf.data()) + from,
                         static_cast<uLong>(pdf.size() - from)),
              Z_OK);
    EXPECT_EQ(size, rows.size() - 1);
    EXPECT_EQ(rows[1], 30); // red of the first px, whatever its filter
}

TEST(RowFile, PdfOfALargePageHasALargeUnit) {
    const TemporaryDirectory folder;
    const auto pageOf = [&](cv::Size2d dpi) {
        RowFile file(folder / "a.pdf", {4096, 512}, CV_8UC1, dpi);
        file.write(cv::Mat(512, 4096, CV_8UC1, cv::Scalar(200)));
        file.finish();
        const std::string pdf = slurp(folder / "a.pdf");
        std::istringstream box(pdf.substr(pdf.find("/MediaBox [0 0 ") + 15, 40));
        cv::Size2d size;
        box >> size.width >> size.height;
        EXPECT_LE(std::max(size.width, size.height), 14400) << dpi;
        const std::size_t unit = pdf.find("/UserUnit ");
        EXPECT_EQ(unit != std::string::npos, pdf.substr(0, 8) == "%PDF-1.6") << dpi;
        const double points = unit == std::string::npos ? 1 : std::stod(pdf.substr(unit + 10));
        return cv::Size2d(size.width * points, size.height * points);
    };
    const auto expectNear = [](cv::Size2d size, cv::Size2d expected) {
        EXPECT_NEAR(size.width, expected.width, 1e-6);
        EXPECT_NEAR(size.height, expected.height, 1e-6);
    };
    expectNear(pageOf({20.48, 20.48}), {14400, 1800});
    expectNear(pageOf({10, 20}), {29491.2, 1843.2});
    expectNear(pageOf({40, 12}), {7372.8, 3072});
}

TEST(RowFile, NamesWhatItCannotWrite) {
    EXPECT_EQ(
        errorOf([] { const RowFile file("a.jpg", cv::Size(4, 4), CV_8UC3, cv::Size2d(72, 72)); }),
        "a.jpg: is no format of prints, expected .png, .tif or .pdf");
    const TemporaryDirectory folder;
    RowFile file(folder / "a.png", {4, 4}, CV_8UC3, {72, 72});
    file.write(cv::Mat(3, 4, CV_8UC3, cv::Scalar()));
    EXPECT_TRUE(holds(errorOf([&] { file.finish(); }), "a.png: has 0 rows, expected 4"));
    EXPECT_FALSE(fs::exists(folder / "a.png"));
}

// Views of one colour each, looked at through the lenses of the calibration without bleed.
TEST(PrintSheet, TheCutPrintShowsTheViews) {
    const TemporaryDirectory folder;
    for (const double angle : {0.0, 6.0}) {
        LensNumbers numbers = numbersOf(37.3, 300, 30, 20);
        numbers.angle = angle;
        const Display print = displayOf(calibrationOf(numbers));
        const PrintSheet sheet(print, {});
        QuiltLayout layout = sheet.display().quilt;
        layout.tileSize = {5, 4};
        cv::Mat quilt(layout.size(), CV_8UC3);
        for (int i = 0; i < layout.viewCount; ++i)
            quilt(layout.tile(i)).setTo(cv::Scalar(20 * i, 100, 250 - 20 * i));
        const Quilt2Native renderer(sheet.display().calibration, layout, {});
        sheet.write(folder / "print.png",
                    [&](const RowSink& rows) { renderer.render(quilt, rows); });
        const cv::Mat whole = cv::imread((folder / "print.png").string());
        ASSERT_EQ(whole.size(), sheet.size());
        ASSERT_EQ(sheet.picture().size(), print.panelSize());
        const cv::Mat cut = whole(sheet.picture()).clone();
        for (int i = 0; i < layout.viewCount; ++i) {
            cv::Mat seen;
            simulateView(cut, print.calibration, eyeAtView(i, layout.viewCount), seen);
            EXPECT_TRUE(samePicture(
                seen, cv::Mat(cut.size(), CV_8UC3, cv::Scalar(20 * i, 100, 250 - 20 * i))))
                << "view " << i << ", angle " << angle;
        }
    }
}

TEST(PrintSheet, MarksAreWhereTheyAreToBe) {
    const TemporaryDirectory folder;
    const Display print = printOf(40, 400, 60, 50);
    const PrintSheet sheet(print, {3, true, "Printer"});
    const cv::Size native = sheet.display().panelSize();
    const cv::Mat grey(native, CV_8UC3, cv::Scalar::all(90));
    sheet.write(folder / "a.png", [&](const RowSink& rows) { rows(grey); });
    const cv::Mat whole = cv::imread((folder / "a.png").string(), cv::IMREAD_GRAYSCALE);
    const auto px = [](double mm) { return static_cast<int>(std::lround(mm / 25.4 * 400)); };
    const cv::Rect cut = sheet.picture();
    EXPECT_EQ(native, print.panelSize() + cv::Size(2 * px(3), 2 * px(3)));
    EXPECT_EQ(cut.tl(), cv::Point(px(10) + px(3), px(10) + px(3)));
    // crop marks continue the cuts
    EXPECT_EQ(whole.at<uchar>(px(4), cut.x), 0);
    EXPECT_EQ(whole.at<uchar>(px(4), cut.br().x), 0);
    EXPECT_EQ(whole.at<uchar>(cut.y, px(4)), 0);
    EXPECT_EQ(whole.at<uchar>(cut.br().y, whole.cols - px(4)), 0);
    // strips: lenses are 10 px wide, two black, two white, and begin where those of the picture do
    const LensGeometry g = lensGeometry(print.calibration);
    for (const int from : {px(2), whole.cols - px(7)}) {
        int black = 0;
        for (int x = from; x < from + px(5); ++x) {
            const bool isBlack = whole.at<uchar>(cut.y + cut.height / 2, x) == 0;
            black += isBlack ? 1 : 0;
            EXPECT_EQ(isBlack, whole.at<uchar>(cut.y + px(6), x) == 0) << "straight down";
            if (x == from || isBlack == (whole.at<uchar>(cut.y + px(6), x - 1) == 0)) continue;
            const double lens = (x - cut.x) * g.periodsPerWidth / g.panelWidth;
            EXPECT_NEAR(lens, std::round(lens), 0.051) << "edges are between lenses";
        }
        EXPECT_NEAR(black, px(5) / 2.0, 20);
    }
    const cv::Mat text = whole.rowRange(whole.rows - px(6), whole.rows);
    EXPECT_GT(cv::countNonZero(text < 128), 200);
    EXPECT_EQ(whole.at<uchar>(px(10) + 1, px(10) + 1), 90) << "bleed";

    const PrintSheet plain(print, {0, false, {}});
    EXPECT_EQ(plain.size(), print.panelSize());
    EXPECT_TRUE(holds(errorOf([&] { const PrintSheet bad(print, {51}); }), "bleed: is 51"));
    Display fine = print;
    fine.calibration.pitch = 201; // of 400 dpi
    EXPECT_TRUE(holds(errorOf([&] { const PrintSheet bad(fine, {}); }), "fewer than two px"));
    EXPECT_TRUE(
        holds(errorOf([&] { const PrintSheet bad(Display(), {}); }), "expected that of a print"));
}

TEST(PrintSheet, BandsOfRowsAreThoseOfTheWholeNative) {
    ALTIRO3D_TAKES(2);
    const Display print = printOf(60, 720, 70, 90); // 1984 x 2551 px: several bands
    const altiro3D::Scene scene{randomPhoto({300, 400}), randomDepth({150, 200})};
    for (const bool isContinuous : {false, true}) {
        NativeOptions options;
        if (isContinuous) options.showAs(Detail::Lens);
        const NativeMaker maker(print, options);
        const altiro3D::Scene fitted =
            placeScene(scene, print.aspect(), maker.workSize(), options).scene;
        cv::Mat whole;
        maker.makeNative(fitted, {}, whole);
        cv::Mat joined;
        int bands = 0;
        maker.makeNative(fitted, {}, [&](const cv::Mat& rows) {
            joined.push_back(rows);
            ++bands;
        });
        EXPECT_GT(bands, 1);
        EXPECT_TRUE(samePicture(joined, whole));
    }
    const QuiltLayout layout{4, 3, {90, 70}, 12};
    const cv::Mat quilt = randomPicture(layout.size(), CV_8UC3);
    const Quilt2Native ofPrint(print.calibration, layout, {});
    cv::Mat joined;
    ofPrint.render(quilt, [&](const cv::Mat& rows) { joined.push_back(rows); });
    cv::Mat whole;
    Quilt2Native(NativeLut(print.calibration, layout)).render(quilt, whole);
    EXPECT_TRUE(samePicture(joined, whole));
}

TEST(PrintSheet, TakesOnlyBandsOfItsNative) {
    const TemporaryDirectory folder;
    const PrintSheet sheet(printOf(60, 360, 30, 20), {});
    const cv::Size panel = sheet.display().panelSize();
    const auto code = [&](cv::Size size, int type) {
        return codeOf([&] {
            sheet.write(folder / "a.png", [&](const RowSink& sink) { sink(cv::Mat(size, type)); });
        });
    };
    EXPECT_EQ(code(panel, CV_8UC1), ErrorCode::InvalidArgument);
    EXPECT_EQ(code({panel.width + 1, panel.height}, CV_8UC3), ErrorCode::Mismatch);
    EXPECT_EQ(code({panel.width, panel.height - 1}, CV_8UC3), ErrorCode::Mismatch);
    EXPECT_FALSE(fs::exists(folder / "a.png"));
}

// The frequency of the strongest wave of a row, in waves per px, near an expected one.
double frequencyOf(const cv::Mat& row, double expected) {
    const auto power = [&](double frequency) {
        std::complex<double> sum;
        for (int x = 0; x < row.cols; ++x) {
            const double window = 1 - std::cos(2 * CV_PI * (x + 0.5) / row.cols);
            sum += window * row.at<uchar>(0, x) * std::polar(1.0, -2 * CV_PI * frequency * x);
        }
        return std::abs(sum);
    };
    double low = expected * (1 - 1e-3);
    double high = expected * (1 + 1e-3);
    for (int i = 0; i < 30; ++i) {
        const double third = (high - low) / 3;
        if (power(low + third) < power(high - third))
            low += third;
        else
            high -= third;
    }
    return (low + high) / 2;
}

TEST(PitchSheet, BandsHaveTheirPitchExactly) {
    const TemporaryDirectory folder;
    const auto file = folder / "pitch.tif";
    LensNumbers numbers;
    for (const bool isHorizontal : {false, true}) {
        numbers = numbersOf(60, 720, isHorizontal ? 40 : 150, isHorizontal ? 100 : 40);
        numbers.isHorizontal = isHorizontal;
        for (const PitchSheetOptions& options :
             {PitchSheetOptions{}, PitchSheetOptions{60.15, 0}, PitchSheetOptions{59, 0.02}}) {
            writePitchSheet(file, calibrationOf(numbers), options);
            cv::Mat sheet = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
            ASSERT_EQ(sheet.type(), CV_8UC1);
            const int footer = static_cast<int>(std::lround(6 / 25.4 * 720));
            sheet = sheet.rowRange(0, sheet.rows - footer).clone();
            if (isHorizontal) cv::transpose(sheet, sheet);
            const double middle = options.around > 0 ? options.around : 60;
            const double step = options.step > 0     ? options.step
                                : options.around > 0 ? 0.0075
                                                     : 0.075;
            for (int i = 0; i < kPitchBands; i += 5) {
                const double lpi = middle + (i - 10) * step;
                const int y = static_cast<int>((i + 0.8) * sheet.rows / kPitchBands);
                const double found = 720 * frequencyOf(sheet.row(y), lpi / 720);
                EXPECT_NEAR(found / lpi, 1, 1e-4) << "band " << i << " of " << middle;
            }
        }
    }
    const auto error = [&](const PitchSheetOptions& options) {
        return errorOf([&] { writePitchSheet(file, calibrationOf(numbers), options); });
    };
    EXPECT_TRUE(holds(error({360, 1}), "around: is 360, expected bands above 0 and up to 360"));
    EXPECT_TRUE(holds(error({0, -1}), "step: is -1, expected LPI, above 0"));
    EXPECT_EQ(codeOf([&] {
                  (void)pitchSheetReach(calibrationOf(numbers), {0, std::nan("")});
              }),
              ErrorCode::InvalidArgument);
    numbers = numbersOf(2, 10, 60, 12); // px so wide that the labels have one column
    numbers.dpiDown = 2000;
    writePitchSheet(file, calibrationOf(numbers), {});
    EXPECT_EQ(cv::imread(file.string()).rows, 945);
}

// Under lenses of another pitch, the tone of a band changes as often as the pitches differ over the
// width.
TEST(PitchSheet, OnlyTheRightBandHasOneTone) {
    const TemporaryDirectory folder;
    const auto file = folder / "pitch.png";
    LensNumbers numbers = numbersOf(60, 720, 254, 30);
    writePitchSheet(file, calibrationOf(numbers), {});
    const cv::Mat sheet = cv::imread(file.string());
    numbers.lpi = 60.15; // band 12
    cv::Mat seen;
    simulateView(sheet, calibrationOf(numbers), {0.4, 1.0 / 12}, seen);
    const int footer = static_cast<int>(std::lround(6 / 25.4 * 720));
    for (int i = 0; i < kPitchBands; ++i) {
        cv::Mat row;
        cv::extractChannel(
            seen.row(static_cast<int>((i + 0.8) * (sheet.rows - footer) / kPitchBands)), row, 0);
        cv::blur(row, row, {241, 1}); // where the tone changes, neighbouring lenses differ
        int changes = 0;
        int tone = row.at<uchar>(0, 0);
        for (int x = 1; x < row.cols; ++x) {
            const int here = row.at<uchar>(0, x);
            if ((here > 60 && here < 195) || std::abs(here - tone) < 128) continue;
            tone = here;
            ++changes;
        }
        const double beats = std::abs(i - 12) * 0.075 * 10; // in ten inches
        EXPECT_NEAR(changes, 2 * beats, 1.01) << "band " << i;
    }
}

} // namespace
} // namespace altiro3D::test
