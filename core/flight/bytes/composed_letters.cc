#include "core/flight/bytes/composed_letters.h"

#include <algorithm>
#include <array>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

// A mark, and the letters that take it: each with what it then is (Unicode 15, canonical composition).
struct LettersOfMark {
  char32_t mark;
  std::u32string_view letters;
};

// clang-format off
constexpr std::array<LettersOfMark, 25> kLettersOfMarks{{
    {0x0300, U"AÀEÈIÌOÒUÙaàeèiìoòuùÜǛüǜNǸnǹЕЀИЍеѐиѝĒḔēḕŌṐōṑWẀwẁÂẦâầĂẰăằÊỀêềÔỒôồƠỜơờƯỪưừYỲyỳ"},
    {0x0301, U"AÁEÉIÍOÓUÚYÝaáeéiíoóuúyýCĆcćLĹlĺNŃnńRŔrŕSŚsśZŹzźÜǗüǘGǴgǵÅǺåǻÆǼæǽØǾøǿ¨΅ΑΆΕΈΗΉΙΊΟΌ"
     U"ΥΎΩΏϊΐαάεέηήιίϋΰοόυύωώϒϓГЃКЌгѓкќÇḈçḉĒḖēḗÏḮïḯKḰkḱMḾmḿÕṌõṍŌṒōṓPṔpṕŨṸũṹWẂwẃÂẤâấĂẮăắ"
     U"ÊẾêếÔỐôốƠỚơớƯỨưứ"},
    {0x0302, U"AÂEÊIÎOÔUÛaâeêiîoôuûCĈcĉGĜgĝHĤhĥJĴjĵSŜsŝWŴwŵYŶyŷZẐzẑẠẬạậẸỆẹệỌỘọộ"},
    {0x0303, U"AÃNÑOÕaãnñoõIĨiĩUŨuũVṼvṽÂẪâẫĂẴăẵEẼeẽÊỄêễÔỖôỗƠỠơỡƯỮưữYỸyỹ"},
    {0x0304, U"AĀaāEĒeēIĪiīOŌoōUŪuūÜǕüǖÄǞäǟȦǠȧǡÆǢæǣǪǬǫǭÖȪöȫÕȬõȭȮȰȯȱYȲyȳИӢиӣУӮуӯGḠgḡḶḸḷḹṚṜṛṝ"},
    {0x0306, U"AĂaăEĔeĕGĞgğIĬiĭOŎoŏUŬuŭУЎИЙийуўЖӁжӂАӐаӑЕӖеӗȨḜȩḝẠẶạặ"},
    {0x0307, U"CĊcċEĖeėGĠgġIİZŻzżAȦaȧOȮoȯBḂbḃDḊdḋFḞfḟHḢhḣMṀmṁNṄnṅPṖpṗRṘrṙSṠsṡŚṤśṥŠṦšṧṢṨṣṩTṪtṫWẆ"
     U"wẇXẊxẋYẎyẏſẛ"},
    {0x0308, U"AÄEËIÏOÖUÜaäeëiïoöuüyÿYŸΙΪΥΫιϊυϋϒϔЕЁІЇеёіїАӒаӓӘӚәӛЖӜжӝЗӞзӟИӤиӥОӦоӧӨӪөӫЭӬэӭУӰуӱЧӴ"
     U"чӵЫӸыӹHḦhḧÕṎõṏŪṺūṻWẄwẅXẌxẍtẗ"},
    {0x0309, U"AẢaảÂẨâẩĂẲăẳEẺeẻÊỂêểIỈiỉOỎoỏÔỔôổƠỞơởUỦuủƯỬưửYỶyỷ"},
    {0x030a, U"AÅaåUŮuůwẘyẙ"},
    {0x030b, U"OŐoőUŰuűУӲуӳ"},
    {0x030c, U"CČcčDĎdďEĚeěLĽlľNŇnňRŘrřSŠsšTŤtťZŽzžAǍaǎIǏiǐOǑoǒUǓuǔÜǙüǚGǦgǧKǨkǩƷǮʒǯjǰHȞhȟ"},
    {0x030f, U"AȀaȁEȄeȅIȈiȉOȌoȍRȐrȑUȔuȕѴѶѵѷ"},
    {0x0311, U"AȂaȃEȆeȇIȊiȋOȎoȏRȒrȓUȖuȗ"},
    {0x031b, U"OƠoơUƯuư"},
    {0x0323, U"BḄbḅDḌdḍHḤhḥKḲkḳLḶlḷMṂmṃNṆnṇRṚrṛSṢsṣTṬtṭVṾvṿWẈwẉZẒzẓAẠaạEẸeẹIỊiịOỌoọƠỢơợUỤuụƯỰưự"
     U"YỴyỵ"},
    {0x0324, U"UṲuṳ"},
    {0x0325, U"AḀaḁ"},
    {0x0326, U"SȘsșTȚtț"},
    {0x0327, U"CÇcçGĢgģKĶkķLĻlļNŅnņRŖrŗSŞsşTŢtţEȨeȩDḐdḑHḨhḩ"},
    {0x0328, U"AĄaąEĘeęIĮiįUŲuųOǪoǫ"},
    {0x032d, U"DḒdḓEḘeḙLḼlḽNṊnṋTṰtṱUṶuṷ"},
    {0x032e, U"HḪhḫ"},
    {0x0330, U"EḚeḛIḬiḭUṴuṵ"},
    {0x0331, U"BḆbḇDḎdḏKḴkḵLḺlḻNṈnṉRṞrṟTṮtṯZẔzẕhẖ"},
}};
// clang-format on

constexpr char32_t kFirstMark = 0x300, kLastMark = 0x36f;

char32_t WithMark(char32_t letter, char32_t mark) {
  const auto found = std::find_if(kLettersOfMarks.begin(), kLettersOfMarks.end(),
                                  [&](const LettersOfMark& one) { return one.mark == mark; });
  if (found == kLettersOfMarks.end()) return 0;
  for (std::size_t i = 0; i + 1 < found->letters.size(); i += 2) {
    if (found->letters[i] == letter) return found->letters[i + 1];
  }
  return 0;
}

// Bytes of the character that begins with `first`, as UTF-8 counts them; a stray byte counts alone.
std::size_t LengthOf(unsigned char first) {
  return first < 0xc0 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
}

// 0: no whole character of up to three bytes, beyond which no letter of the table is.
char32_t CharacterOf(std::string_view bytes) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  if (bytes.empty() || bytes.size() > 3 || bytes.size() != LengthOf(at(0))) return 0;
  if (bytes.size() == 1) return at(0) < 0x80 ? at(0) : 0;
  char32_t character = at(0) & (bytes.size() == 2 ? 0x1fu : 0x0fu);
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    if ((at(i) >> 6) != 2) return 0;
    character = (character << 6) | (at(i) & 0x3fu);
  }
  return character;
}

}  // namespace

std::string WithComposedLetters(std::string_view text) {
  if (text.find_first_of("\xcc\xcd") == std::string_view::npos)
    return std::string(text);  // no mark begins so
  std::string composed;
  std::size_t last = 0;  // where the last character of `composed` begins
  while (!text.empty()) {
    const std::string_view bytes = text.substr(0, LengthOf(static_cast<unsigned char>(text.front())));
    text.remove_prefix(bytes.size());
    const char32_t character = CharacterOf(bytes);
    const bool is_mark = character >= kFirstMark && character <= kLastMark;
    const char32_t letter = is_mark ? CharacterOf(std::string_view(composed).substr(last)) : 0;
    if (const char32_t whole = letter == 0 ? 0 : WithMark(letter, character); whole != 0) {
      composed.resize(last);
      AppendUtf8(whole, composed);
      continue;
    }
    last = composed.size();
    composed += bytes;
  }
  return composed;
}

}  // namespace skyquilt::flight
