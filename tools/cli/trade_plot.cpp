#include "cli/trade_plot.hpp"

#include "cli/run_tool.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D::tools {

namespace {

constexpr double kWidth = 760;
constexpr double kHeight = 460;
constexpr double kLeft = 60;
constexpr double kRight = 190; // room for labels
constexpr double kTop = 40;
constexpr double kBottom = 50;
constexpr double kLabelHeight = 15;

std::string label(double x, double y, std::string text, const std::string& anchor,
                  const std::string& more = "") {
    for (const auto& [sign, word] : {std::pair('&', "&amp;"), std::pair('<', "&lt;")}) {
        for (std::size_t at = 0; (at = text.find(sign, at)) != std::string::npos; ++at)
            text.replace(at, 1, word);
    }
    return "<text x=\"" + fixed(x, 1) + "\" y=\"" + fixed(y, 1) + "\" text-anchor=\"" + anchor +
           "\"" + more + ">" + text + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
    return "<line x1=\"" + fixed(x1, 1) + "\" y1=\"" + fixed(y1, 1) + "\" x2=\"" + fixed(x2, 1) +
           "\" y2=\"" + fixed(y2, 1) + "\" stroke=\"" + style + "/>\n";
}

bool beaten(const TradePoint& point, const std::vector<TradePoint>& points) {
    return std::any_of(points.begin(), points.end(), [&](const TradePoint& other) {
        return other.milliseconds <= point.milliseconds && other.decibels >= point.decibels &&
               (other.milliseconds < point.milliseconds || other.decibels > point.decibels);
    });
}

bool isQuicker(const TradePoint& a, const TradePoint& b) {
    return a.milliseconds < b.milliseconds;
}

bool isWorse(const TradePoint& a, const TradePoint& b) {
    return a.decibels < b.decibels;
}

} // namespace

std::string tradePlotSvg(const std::vector<TradePoint>& points, const std::string& title) {
    double fastest = 1;
    double slowest = 10;
    double lowest = 20;
    double highest = 30;
    if (!points.empty()) {
        const auto [quick, slow] = std::minmax_element(points.begin(), points.end(), isQuicker);
        const auto [low, high] = std::minmax_element(points.begin(), points.end(), isWorse);
        fastest = std::max(quick->milliseconds, 1e-6) / 1.5;
        slowest = std::max(slow->milliseconds, 1e-6) * 1.5;
        lowest = std::floor(low->decibels - 0.5);
        highest = std::ceil(high->decibels + 0.5);
    }
    const auto xOf = [&](double milliseconds) {
        const double place = std::log(milliseconds / fastest) / std::log(slowest / fastest);
        return kLeft + place * (kWidth - kLeft - kRight);
    };
    const auto yOf = [&](double decibels) {
        return kHeight - kBottom -
               (decibels - lowest) / (highest - lowest) * (kHeight - kTop - kBottom);
    };
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + fixed(kWidth, 0) +
                      "\" height=\"" + fixed(kHeight, 0) +
                      "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    svg += label(kLeft, kTop - 16, "Accuracy over time per view: " + title, "start",
                 " font-size=\"15\"");
    for (int i = 0; i <= static_cast<int>(highest - lowest); ++i) {
        const double decibels = lowest + i;
        svg += line(kLeft, yOf(decibels), kWidth - kRight, yOf(decibels), "#ddd\"") +
               label(kLeft - 6, yOf(decibels) + 4, fixed(decibels, 0), "end");
    }
    const auto firstDecade = static_cast<int>(std::floor(std::log10(fastest)));
    const auto lastDecade = static_cast<int>(std::floor(std::log10(slowest)));
    for (int decade = firstDecade; decade <= lastDecade; ++decade) {
        for (double step : {1.0, 2.0, 5.0}) {
            const double tick = std::pow(10, decade) * step;
            if (tick < fastest || tick > slowest) continue;
            svg += line(xOf(tick), kTop, xOf(tick), kHeight - kBottom, "#ddd\"") +
                   label(xOf(tick), kHeight - kBottom + 16, numberText(tick), "middle");
        }
    }
    svg += label((kLeft + kWidth - kRight) / 2, kHeight - 12, "ms per view", "middle");
    svg += label(16, kTop - 16, "dB", "start");

    std::vector<TradePoint> front;
    std::copy_if(points.begin(), points.end(), std::back_inserter(front),
                 [&](const TradePoint& point) { return !beaten(point, points); });
    std::sort(front.begin(), front.end(), isQuicker);
    svg += "<polyline fill=\"none\" stroke=\"#2a7\" stroke-width=\"2\" points=\"";
    for (const TradePoint& point : front) {
        svg += fixed(xOf(point.milliseconds), 1) + "," + fixed(yOf(point.decibels), 1) + " ";
    }
    svg += "\"/>\n";
    // Labels stand in a column at the right, by accuracy, each joined to its point.
    std::vector<TradePoint> labelled = points;
    std::stable_sort(labelled.rbegin(), labelled.rend(), isWorse);
    double lastLabel = kTop - kLabelHeight;
    const double column = kWidth - kRight + 24;
    for (std::size_t i = 0; i < labelled.size(); ++i) {
        const TradePoint& point = labelled[i];
        const double below = static_cast<double>(labelled.size() - i) * kLabelHeight;
        const double y = std::max(lastLabel + kLabelHeight,
                                  std::min(yOf(point.decibels), kHeight - kBottom + 10 - below));
        lastLabel = y;
        const std::string colour = beaten(point, points) ? "#888" : "#2a7";
        const double x = xOf(point.milliseconds);
        svg += line(x, yOf(point.decibels), column - 4, y, colour + "\" stroke-width=\"0.5\"") +
               "<circle cx=\"" + fixed(x, 1) + "\" cy=\"" + fixed(yOf(point.decibels), 1) +
               "\" r=\"4\" fill=\"" + colour + "\"/>\n" +
               label(column, y + 4, point.name, "start", " fill=\"" + colour + "\"");
    }
    return svg + "</svg>\n";
}

} // namespace altiro3D::tools
