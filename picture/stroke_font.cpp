// The glyphs are the Hershey font "Simplex roman". The Hershey Fonts were originally created by
// Dr. A. V. Hershey while working at the U. S. National Bureau of Standards. The format of the font
// data in this distribution was originally created by James Hurt, Cognition, Inc., 900 Technology
// Park Drive, Billerica, MA 01821 (mit-eddie!ci-dandelion!hurt).
// SPDX-License-Identifier: Apache-2.0
#include "picture/stroke_font.h"

#include <array>

namespace diesink {
namespace {

// One string a character from the blank on: pairs of letters whose distances from R are x and y
// (down); the first pair is the left and right border, " R" lifts the pen. The capitals go from
// y = -12 to 9.
constexpr std::array<std::string_view, 95> kGlyphs{
    // clang-format off
    "JZ",  // blank
    "MWRFRT RRYQZR[SZRY",  // !
    "JZNFNM RVFVM",  // "
    "H]SBLb RYBRb RLOZO RKUYU",  // #
    "H\\PBP_ RTBT_ RYIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZKX",  // $
    "F^[FI[ RNFPHPJOLMMKMIKIIJGLFNFPGSHVHYG[F RWTUUTWTYV[X[ZZ[X[VYTWT",  // %
    "E_\\O\\N[MZMYNXPVUTXRZP[L[JZIYHWHUISJRQNRMSKSIRGPFNGMIMKNNPQUXWZY[[[\\Z\\Y",  // &
    "MWRHQGRFSGSIRKQL",  // '
    "KYVBTDRGPKOPOTPYR]T`Vb",  // (
    "KYNBPDRGTKUPUTTYR]P`Nb",  // )
    "JZRLRX RMOWU RWOMU",  // *
    "E_RIR[ RIR[R",  // +
    "NVSWRXQWRVSWSYQ[",  // ,
    "E_IR[R",  // -
    "NVRVQWRXSWRV",  // .
    "G][BIb",  // /
    "H\\QFNGLJKOKRLWNZQ[S[VZXWYRYOXJVGSFQF",  // 0
    "H\\NJPISFS[",  // 1
    "H\\LKLJMHNGPFTFVGWHXJXLWNUQK[Y[",  // 2
    "H\\MFXFRNUNWOXPYSYUXXVZS[P[MZLYKW",  // 3
    "H\\UFKTZT RUFU[",  // 4
    "H\\WFMFLOMNPMSMVNXPYSYUXXVZS[P[MZLYKW",  // 5
    "H\\XIWGTFRFOGMJLOLTMXOZR[S[VZXXYUYTXQVOSNRNOOMQLT",  // 6
    "H\\YFO[ RKFYF",  // 7
    "H\\PFMGLILKMMONSOVPXRYTYWXYWZT[P[MZLYKWKTLRNPQOUNWMXKXIWGTFPF",  // 8
    "H\\XMWPURRSQSNRLPKMKLLINGQFRFUGWIXMXRWWUZR[P[MZLX",  // 9
    "NVROQPRQSPRO RRVQWRXSWRV",  // :
    "NVROQPRQSPRO RSWRXQWRVSWSYQ[",  // ;
    "F^ZIJRZ[",  // <
    "E_IO[O RIU[U",  // =
    "F^JIZRJ[",  // >
    "I[LKLJMHNGPFTFVGWHXJXLWNVORQRT RRYQZR[SZRY",  // ?
    "E`WNVLTKQKOLNMMPMSNUPVSVUUVS RQKOMNPNSOUPV RWKVSVUXVZV\\T]Q]O\\L[JYHWGTFQFNGLHJJILHOHRIUJWLYNZQ[T[WZYYZX RXKWSWUXV",  // @
    "I[RFJ[ RRFZ[ RMTWT",  // A
    "G\\KFK[ RKFTFWGXHYJYLXNWOTP RKPTPWQXRYTYWXYWZT[K[",  // B
    "H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZV",  // C
    "G\\KFK[ RKFRFUGWIXKYNYSXVWXUZR[K[",  // D
    "H[LFL[ RLFYF RLPTP RL[Y[",  // E
    "HZLFL[ RLFYF RLPTP",  // F
    "H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZVZS RUSZS",  // G
    "G]KFK[ RYFY[ RKPYP",  // H
    "NVRFR[",  // I
    "JZVFVVUYTZR[P[NZMYLVLT",  // J
    "G\\KFK[ RYFKT RPOY[",  // K
    "HYLFL[ RL[X[",  // L
    "F^JFJ[ RJFR[ RZFR[ RZFZ[",  // M
    "G]KFK[ RKFY[ RYFY[",  // N
    "G]PFNGLIKKJNJSKVLXNZP[T[VZXXYVZSZNYKXIVGTFPF",  // O
    "G\\KFK[ RKFTFWGXHYJYMXOWPTQKQ",  // P
    "G]PFNGLIKKJNJSKVLXNZP[T[VZXXYVZSZNYKXIVGTFPF RSWY]",  // Q
    "G\\KFK[ RKFTFWGXHYJYLXNWOTPKP RRPY[",  // R
    "H\\YIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZKX",  // S
    "JZRFR[ RKFYF",  // T
    "G]KFKULXNZQ[S[VZXXYUYF",  // U
    "I[JFR[ RZFR[",  // V
    "F^HFM[ RRFM[ RRFW[ R\\FW[",  // W
    "H\\KFY[ RYFK[",  // X
    "I[JFRPR[ RZFRP",  // Y
    "H\\YFK[ RKFYF RK[Y[",  // Z
    "KYOBOb RPBPb ROBVB RObVb",  // [
    "KYKFY^",  // backslash
    "KYTBTb RUBUb RNBUB RNbUb",  // ]
    "JZRDJR RRDZR",  // ^
    "I[Ib[b",  // _
    "NVSKQMQORPSORNQO",  // `
    "I\\XMX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",  // a
    "H[LFL[ RLPNNPMSMUNWPXSXUWXUZS[P[NZLX",  // b
    "I[XPVNTMQMONMPLSLUMXOZQ[T[VZXX",  // c
    "I\\XFX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",  // d
    "I[LSXSXQWOVNTMQMONMPLSLUMXOZQ[T[VZXX",  // e
    "MYWFUFSGRJR[ ROMVM",  // f
    "I\\XMX]W`VaTbQbOa RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",  // g
    "I\\MFM[ RMQPNRMUMWNXQX[",  // h
    "NVQFRGSFREQF RRMR[",  // i
    "MWRFSGTFSERF RSMS^RaPbNb",  // j
    "IZMFM[ RWMMW RQSX[",  // k
    "NVRFR[",  // l
    "CaGMG[ RGQJNLMOMQNRQR[ RRQUNWMZM\\N]Q][",  // m
    "I\\MMM[ RMQPNRMUMWNXQX[",  // n
    "I\\QMONMPLSLUMXOZQ[T[VZXXYUYSXPVNTMQM",  // o
    "H[LMLb RLPNNPMSMUNWPXSXUWXUZS[P[NZLX",  // p
    "I\\XMXb RXPVNTMQMONMPLSLUMXOZQ[T[VZXX",  // q
    "KXOMO[ ROSPPRNTMWM",  // r
    "J[XPWNTMQMNNMPNRPSUTWUXWXXWZT[Q[NZMX",  // s
    "MYRFRWSZU[W[ ROMVM",  // t
    "I\\MMMWNZP[S[UZXW RXMX[",  // u
    "JZLMR[ RXMR[",  // v
    "G]JMN[ RRMN[ RRMV[ RZMV[",  // w
    "J[MMX[ RXMM[",  // x
    "JZLMR[ RXMR[P_NaLbKb",  // y
    "J[XMM[ RMMXM RM[X[",  // z
    "KYTBRCQDPFPHQJRKSMSOQQ RRCQEQGRISJTLTNSPORSTTVTXSZR[Q]Q_Ra RQSSUSWRYQZP\\P^Q`RaTb",  // {
    "NVRBRb",  // |
    "KYPBRCSDTFTHSJRKQMQOSQ RRCSESGRIQJPLPNQPURQTPVPXQZR[S]S_Ra RSSQUQWRYSZT\\T^S`RaPb",  // }
    "F^IUISJPLONOPPTSVTXTZS[Q RISJQLPNPPQTTVUXUZT[Q[O",  // ~
    // clang-format on
};
constexpr int kTop = -12, kBase = 9;

std::string_view glyph_of(char character) {
  const int k = character - ' ';
  return kGlyphs[k >= 0 && k < 95 ? static_cast<std::size_t>(k) : '?' - ' '];
}

}  // namespace

double text_width(std::string_view text, double height) {
  int width = 0;
  for (const char each : text) width += glyph_of(each)[1] - glyph_of(each)[0];
  return width * height / (kBase - kTop);
}

std::vector<Stroke> text_strokes(std::string_view text, const Vec2& at, double height) {
  const double scale = height / (kBase - kTop);
  std::vector<Stroke> strokes;
  double pen = at.x();
  for (const char each : text) {
    const std::string_view glyph = glyph_of(each);
    Stroke stroke;
    for (std::size_t k = 2; k + 1 < glyph.size(); k += 2) {
      if (glyph[k] == ' ') {
        strokes.push_back(std::move(stroke));
        stroke.clear();
        continue;
      }
      stroke.emplace_back(pen + (glyph[k] - glyph[0]) * scale,
                          at.y() + (glyph[k + 1] - 'R' - kBase) * scale);
    }
    if (!stroke.empty()) strokes.push_back(std::move(stroke));
    pen += (glyph[1] - glyph[0]) * scale;
  }
  return strokes;
}

}  // namespace diesink
