// Comparison of file names that look the same to people: other case, and other code points of the
// same letters. Quoting of names for a shell.

#include "altiro3D/file_io.hpp"
#include "base/system_process.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace altiro3D {

namespace {

// Letters without and with a mark, alternately. Files from a Mac have the letter and the mark.
struct Marked {
    char16_t mark;
    std::u16string_view letters;
};
constexpr Marked kMarked[] = {
    {u'\u0300', u"AÀEÈIÌOÒUÙaàeèiìoòuùÜǛüǜЕЀИЍеѐиѝWẀwẁÂẦâầĂẰăằÊỀêềÔỒôồƠỜơờƯỪưừYỲyỳ"},
    {u'\u0301', u"AÁEÉIÍOÓUÚYÝaáeéiíoóuúyýCĆcćLĹlĺNŃnńRŔrŕSŚsśZŹzźÜǗüǘΑΆΕΈΗΉΙΊΟΌΥΎΩΏϊΐαάεέηήιί"
                u"ϋΰοόυύωώГЃКЌгѓкќWẂwẃÂẤâấĂẮăắÊẾêếÔỐôốƠỚơớƯỨưứ"},
    {u'\u0302', u"AÂEÊIÎOÔUÛaâeêiîoôuûCĈcĉGĜgĝHĤhĥJĴjĵSŜsŝWŴwŵYŶyŷẠẬạậẸỆẹệỌỘọộ"},
    {u'\u0303', u"AÃNÑOÕaãnñoõIĨiĩUŨuũÂẪâẫĂẴăẵEẼeẽÊỄêễÔỖôỗƠỠơỡƯỮưữYỸyỹ"},
    {u'\u0304', u"AĀaāEĒeēIĪiīOŌoōUŪuūÜǕüǖ"},
    {u'\u0306', u"AĂaăEĔeĕGĞgğIĬiĭOŎoŏUŬuŭУЎИЙийуўẠẶạặ"},
    {u'\u0307', u"CĊcċEĖeėGĠgġIİZŻzż"},
    {u'\u0308', u"AÄEËIÏOÖUÜaäeëiïoöuüyÿYŸΙΪΥΫιϊυϋЕЁІЇеёіїWẄwẅ"},
    {u'\u0309', u"AẢaảÂẨâẩĂẲăẳEẺeẻÊỂêểIỈiỉOỎoỏÔỔôổƠỞơởUỦuủƯỬưửYỶyỷ"},
    {u'\u030A', u"AÅaåUŮuů"},
    {u'\u030B', u"OŐoőUŰuű"},
    {u'\u030C', u"CČcčDĎdďEĚeěLĽlľNŇnňRŘrřSŠsšTŤtťZŽzžAǍaǎIǏiǐOǑoǒUǓuǔÜǙüǚ"},
    {u'\u031B', u"OƠoơUƯuư"},
    {u'\u0323', u"AẠaạEẸeẹIỊiịOỌoọƠỢơợUỤuụƯỰưựYỴyỵ"},
    {u'\u0326', u"SȘsșTȚtț"},
    {u'\u0327', u"CÇcçGĢgģKĶkķLĻlļNŅnņRŖrŗSŞsşTŢtţ"},
    {u'\u0328', u"AĄaąEĘeęIĮiįUŲuų"},
    {u'\u3099',
     u"かがきぎくぐけげこごさざしじすずせぜそぞただちぢつづてでとどはばひびふぶへべ"
     u"ほぼうゔゝゞカガキギクグケゲコゴサザシジスズセゼソゾタダチヂツヅテデトドハバヒビフ"
     u"ブヘベホボウヴワヷヰヸヱヹヲヺヽヾ"},
    {u'\u309A', u"はぱひぴふぷへぺほぽハパヒピフプヘペホポ"},
};

// The letter composed of a letter and what follows it; 0 if they compose none.
char32_t composed(char32_t letter, char32_t next) {
    constexpr char32_t kLeads = 0x1100, kVowels = 0x1161, kTails = 0x11a7, kSyllables = 0xac00;
    const char32_t lead = letter - kLeads, vowel = next - kVowels, tail = next - kTails;
    if (lead < 19 && vowel < 21) return kSyllables + (lead * 21 + vowel) * 28; // Hangul
    const char32_t syllable = letter - kSyllables;
    if (syllable < 19 * 21 * 28 && syllable % 28 == 0 && tail - 1 < 27) return letter + tail;
    if (next < 0x300) return 0;
    for (const Marked& marked : kMarked) {
        for (std::size_t i = 0; marked.mark == next && i < marked.letters.size(); i += 2) {
            if (marked.letters[i] == letter) return marked.letters[i + 1];
        }
    }
    return 0;
}

// Reads a code point of UTF-8 and moves on; a byte that is not UTF-8 counts as a code point.
char32_t readCodePoint(const std::string& text, std::size_t& at) {
    const auto byte = [&](std::size_t i) -> std::uint32_t {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
    };
    const std::uint32_t first = byte(at++);
    const std::size_t more = first < 0xc0 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    char32_t code = first & (0x3fU >> more);
    for (std::size_t i = 0; i < more; ++i) {
        if ((byte(at + i) & 0xc0U) != 0x80) return 0x110000 + first;
        code = (code << 6U) | (byte(at + i) & 0x3fU);
    }
    if (more == 0) return first < 0x80 ? first : 0x110000 + first;
    at += more;
    return code;
}

} // namespace

std::u32string comparableName(const std::string& name) {
    std::u32string letters;
    for (std::size_t at = 0; at < name.size();) {
        const char32_t next = readCodePoint(name, at);
        const char32_t whole = letters.empty() ? 0 : composed(letters.back(), next);
        if (whole != 0) letters.back() = whole;
        if (whole == 0) letters += next;
    }
    for (char32_t& letter : letters)
        if (letter < 0x80)
            letter = static_cast<unsigned char>(lowerCase(static_cast<char>(letter)));
    return letters;
}

std::string shellWord(const std::string& text) {
    const bool isPlain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        const char lower = lowerCase(c);
        return static_cast<unsigned char>(c) >= 0x80 || isDigit(c) ||
               (lower >= 'a' && lower <= 'z') ||
               std::string_view("-_./,=:%@+").find(c) != std::string_view::npos;
    });
    if (isPlain) return text;
    std::string word(1, kShellQuote);
    for (const char c : text)
        word += c == kShellQuote ? kQuoteInShellQuotes : std::string(1, c);
    return word + kShellQuote;
}

} // namespace altiro3D
