#include "image/xmp.hpp"

#include "base/owned.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <expat.h>
#include <memory>
#include <utility>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kLongValue = 1024;                // taken out before the XML parser
constexpr std::size_t kMaxBytes = std::size_t{1} << 20; // limit for what remains
constexpr std::size_t kMaxProperties = 10000;
constexpr int kMaxDepth = 100;
constexpr char kSeparator = '\n';                          // between namespace and name
constexpr string_view kReference = "altiro3D-long-value:"; // takes the place of a long value

// Without what precedes the first element: packet marks (<?xpacket ...?>), which may hold bytes of
// another encoding, XML declarations, which expat takes only at the very start, and comments.
string_view withoutProlog(string_view text) {
    while (true) {
        const std::size_t tag = text.find('<');
        if (tag == string_view::npos) return {};
        text.remove_prefix(tag);
        const bool isMark = startsWith(text, "<?");
        if (!isMark && !startsWith(text, "<!--")) return text;
        const string_view close = isMark ? "?>" : "-->";
        const std::size_t end = text.find(close);
        if (end == string_view::npos) return {};
        text.remove_prefix(end + close.size());
    }
}

// Replaces long values by references: expat needs 10 ms for 1 MB of base64, and this 0.1 ms.
std::string withoutLongValues(string_view text, std::vector<string_view>& values) {
    std::string rest;
    const auto add = [&](string_view part) {
        if (part.size() < kLongValue) {
            rest += part;
            return;
        }
        rest += std::string(kReference) + std::to_string(values.size());
        values.push_back(part);
    };
    const auto end = [&](std::size_t found) { return std::min(found, text.size()); };
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t tag = end(text.find('<', at));
        add(text.substr(at, tag - at));
        at = tag;
        // Quotes mean nothing in comments and raw text.
        for (const auto& [begin, close] :
             {std::pair<string_view, string_view>{"<!--", "-->"}, {"<![CDATA[", "]]>"}}) {
            if (!startsWith(text.substr(at), begin)) continue;
            const std::size_t after = end(text.find(close, at + begin.size()));
            const std::size_t next = std::min(after + close.size(), text.size());
            rest += text.substr(at, next - at);
            at = next;
        }
        if (at > tag) continue;
        while (at < text.size()) { // inside the tag
            const std::size_t next = end(text.find_first_of("\"'>", at));
            rest += text.substr(at, next - at);
            at = next;
            if (at == text.size()) break;
            const char mark = text[at++];
            rest += mark;
            if (mark == '>') break;
            const std::size_t close = end(text.find(mark, at));
            add(text.substr(at, close - at));
            if (close < text.size()) rest += mark;
            at = std::min(close + 1, text.size());
        }
        if (rest.size() > kMaxBytes) break;
    }
    return rest;
}

std::pair<string_view, string_view> spaceAndName(string_view name) {
    const std::size_t separator = name.find(kSeparator);
    if (separator == string_view::npos) return {string_view(), name};
    return {name.substr(0, separator), name.substr(separator + 1)};
}

std::uint64_t wholeNumber(string_view text) {
    std::uint64_t value = 0;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
    return parsed.ec == std::errc() ? value : 0;
}

// Collects properties and items from the events of the XML parser.
class Collector {
  public:
    Collector(XML_Parser parser, std::vector<XmpProperty>& properties, std::vector<XmpItem>& items)
        : parser_(parser), properties_(properties), items_(items) {}

    static void start(void* self, const XML_Char* name, const XML_Char** attributes) {
        guarded(self, [&](Collector& collector) { collector.begin(name, attributes); });
    }
    static void end(void* self, const XML_Char* name) {
        guarded(self, [&](Collector& collector) { collector.close(name); });
    }
    static void text(void* self, const XML_Char* text, int size) {
        guarded(self, [&](Collector& collector) {
            collector.text_.append(text, static_cast<std::size_t>(size));
        });
    }
    // XMP has no document type, and one could define entities that grow without limit.
    static void refuse(void* self, const XML_Char* /*name*/, const XML_Char* /*system*/,
                       const XML_Char* /*publicId*/, int /*internal*/) {
        static_cast<Collector*>(self)->stop();
    }

    /// Throws what was thrown in an event: exceptions must not pass through expat.
    void rethrow() const {
        if (thrown_) std::rethrow_exception(thrown_);
    }

  private:
    template <class Work>
    static void guarded(void* self, const Work& work) {
        auto& collector = *static_cast<Collector*>(self);
        try {
            if (!collector.thrown_) work(collector);
        } catch (...) {
            collector.thrown_ = std::current_exception();
            collector.stop();
        }
    }

    void stop() { XML_StopParser(parser_, XML_FALSE); }

    void begin(const XML_Char* name, const XML_Char** attributes) {
        if (++depth_ > kMaxDepth) return stop();
        text_.clear();
        isLeaf_ = true;
        const string_view local = spaceAndName(name).second;
        if (local == "Directory") directoryDepth_ = depth_;
        if (directoryDepth_ > 0 && local == "li") items_.emplace_back();
        if (local != "li" && local != "Seq" && local != "Alt" && local != "Bag") list_ = name;
        for (; attributes[0] != nullptr; attributes += 2)
            add(attributes[0], attributes[1]);
    }
    void close(const XML_Char* name) {
        if (isLeaf_) add(spaceAndName(name).second == "li" ? string_view(list_) : name, text_);
        isLeaf_ = false;
        text_.clear();
        if (depth_ == directoryDepth_) directoryDepth_ = 0;
        --depth_;
    }
    void add(string_view wholeName, string_view value) {
        if (properties_.size() >= kMaxProperties) return stop();
        const auto [space, name] = spaceAndName(wholeName);
        if (directoryDepth_ > 0 && !items_.empty()) addToItem(name, value, items_.back());
        properties_.push_back({std::string(space), std::string(name), std::string(value)});
    }
    static void addToItem(string_view name, string_view value, XmpItem& item) {
        if (name == "Semantic") item.semantic = value;
        if (name == "DataURI" || name == "URI") item.uri = value;
        if (name == "Length") item.length = wholeNumber(value);
        if (name == "Padding") item.padding = wholeNumber(value);
    }

    XML_Parser parser_;
    std::vector<XmpProperty>& properties_;
    std::vector<XmpItem>& items_;
    std::string text_;
    std::string list_; // the property that lists are of
    std::exception_ptr thrown_;
    bool isLeaf_ = false;
    int depth_ = 0;
    int directoryDepth_ = 0;
};

} // namespace

Xmp::Xmp(string_view text) {
    const std::string rest = withoutLongValues(withoutProlog(text), longValues_);
    if (rest.size() > kMaxBytes) return;
    const std::unique_ptr<XML_ParserStruct, Free<XML_ParserFree>> parser(
        XML_ParserCreateNS(nullptr, kSeparator));
    if (!parser) throw std::bad_alloc();
    Collector collector(parser.get(), properties_, items_);
    XML_SetUserData(parser.get(), &collector);
    XML_SetElementHandler(parser.get(), Collector::start, Collector::end);
    XML_SetCharacterDataHandler(parser.get(), Collector::text);
    XML_SetStartDoctypeDeclHandler(parser.get(), Collector::refuse);
    // what comes before a fault is kept
    static_cast<void>(
        XML_Parse(parser.get(), rest.data(), static_cast<int>(rest.size()), XML_TRUE));
    collector.rethrow();
}

const XmpProperty* Xmp::find(string_view space, string_view name) const {
    const auto found =
        std::find_if(properties_.begin(), properties_.end(), [&](const XmpProperty& property) {
            return property.name == name && property.space.find(space) != std::string::npos;
        });
    return found == properties_.end() ? nullptr : &*found;
}

bool Xmp::has(string_view space, string_view name) const {
    return find(space, name) != nullptr;
}

string_view Xmp::value(string_view space, string_view name) const {
    const XmpProperty* const property = find(space, name);
    if (property == nullptr) return {};
    const string_view value = property->value;
    if (!startsWith(value, kReference)) return value;
    const std::uint64_t index = wholeNumber(value.substr(kReference.size()));
    return index < longValues_.size() ? longValues_[static_cast<std::size_t>(index)]
                                      : string_view();
}

double Xmp::number(string_view space, string_view name) const {
    return numberAt(value(space, name));
}

std::string decodeBase64(string_view text) {
    static constexpr unsigned char kNoDigit = 64;
    static constexpr unsigned char kBlank = 65;
    static const std::array<unsigned char, 256> digits = [] {
        constexpr string_view kDigits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::array<unsigned char, 256> table{};
        table.fill(kNoDigit);
        for (std::size_t i = 0; i < kDigits.size(); ++i)
            table[static_cast<unsigned char>(kDigits[i])] = static_cast<unsigned char>(i);
        for (const char blank : {' ', '\t', '\r', '\n'})
            table[static_cast<unsigned char>(blank)] = kBlank;
        return table;
    }();
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    unsigned bits = 0;
    int count = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const unsigned char digit = digits[static_cast<unsigned char>(text[i])];
        if (digit == kBlank) continue;
        if (text[i] == '&') { // a line break as a character reference
            i = std::min(text.find(';', i), text.size());
            continue;
        }
        if (digit == kNoDigit) break;
        bits = (bits << 6 | digit) & 0xffffffU;
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<char>(bits >> count & 0xffU));
    }
    return bytes;
}

} // namespace altiro3D
