// The report's style sheet: calm, readable on paper, and dark where the reader's system is dark.
#pragma once
#include <string_view>

namespace gantry::record {

inline constexpr std::string_view kStyle = R"css(
:root{color-scheme:light dark;--bg:#f5f6f7;--card:#fff;--ink:#1c2430;--muted:#66717f;--line:#e1e5ea;--accent:#2563a8;
--good:#1a7f55;--warn:#9a6200;--bad:#b3261e;--board:#eaf3ec;--board-edge:#9dbfa6;--part:#d5dae1;--part-edge:#a9b2bd;
--fixture:#e9dfd0;--fixture-edge:#c0a884;--planned:#f4c77f;--actual:#1f4f8f;--band:#d9efe3;--bead:#1a8f78}
@media(prefers-color-scheme:dark){:root{--bg:#14181d;--card:#1c2229;--ink:#e6eaef;--muted:#97a3b1;--line:#2d353f;
--accent:#74abe8;--good:#5cc895;--warn:#e0b04b;--bad:#f28b82;--board:#1d2b23;--board-edge:#44604d;--part:#333c47;
--part-edge:#525e6c;--fixture:#3b3327;--fixture-edge:#6b5a3d;--planned:#7d5a20;--actual:#9ec6f5;--band:#1d3a2d;
--bead:#45c9ad}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:1120px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:27px;font-weight:600;margin:0;letter-spacing:-.01em}
h2{font-size:17px;font-weight:600;margin:0 0 10px}
p{margin:0 0 10px}
.sub,.note,.tick{color:var(--muted)}
.sub{margin:2px 0 18px}
.note{font-size:13px;margin:8px 0 0}
header{display:flex;align-items:center;gap:14px;flex-wrap:wrap}
.verdict{font-weight:600;font-size:14px;padding:3px 13px;border-radius:99px;color:#fff;background:var(--good)}
.verdict.failed{background:var(--bad)}.verdict.warn{background:var(--warn)}
@media(prefers-color-scheme:dark){.verdict{color:#10151a}}
section{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:18px 20px;margin:0 0 16px}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(160px,1fr));gap:12px;margin:0 0 16px}
.tile{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:11px 15px}
.tile b{display:block;font-size:21px;font-weight:600;font-variant-numeric:tabular-nums}
.tile span{color:var(--muted);font-size:13px}
.tile.bad b{color:var(--bad)}.tile.warn b{color:var(--warn)}
.error{border-left:4px solid var(--bad)}
.error+.error{margin-top:12px}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(440px,1fr));gap:16px}
.columns section{margin:0;min-width:0;overflow-x:auto}
.columns{margin:0 0 16px}
.scroll{overflow:auto;max-height:460px}
@media(max-width:520px){.columns{grid-template-columns:1fr}section{overflow-x:auto}}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;font-size:14px}
th{text-align:left;font-weight:500;color:var(--muted);font-size:13px;position:sticky;top:0;background:var(--card)}
td,th{white-space:nowrap;padding:5px 12px 5px 0;border-bottom:1px solid var(--line);vertical-align:middle}
tr:last-child td{border-bottom:0}
.r{text-align:right}
th{white-space:normal;vertical-align:bottom}
.prose,.name{display:inline-block;white-space:normal;overflow-wrap:break-word}
.prose{min-width:11em}.name{max-width:22em}
@media(max-width:520px){.prose{min-width:6.5em}.name{max-width:9em}}
td.r,th.r{padding-right:18px}
.meter{display:inline-block;height:8px;border-radius:4px;background:var(--accent);vertical-align:middle}
.bad{color:var(--bad)}.good{color:var(--good)}
.marks{display:grid;grid-template-columns:repeat(auto-fill,minmax(190px,1fr));gap:14px}
.marks figure{margin:0}
.marks img{width:100%;height:auto;border-radius:7px;display:block}
.noimage{aspect-ratio:5/4;border-radius:7px;background:var(--bg);display:grid;place-items:center;color:var(--muted);font-size:13px;border:1px dashed var(--line)}
figcaption{font-size:13px;margin-top:5px;line-height:1.4}
code,.mono{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;font-size:13px}
.events{margin:0;white-space:pre-wrap;font-size:13px;line-height:1.55}
dl{display:grid;grid-template-columns:max-content 1fr;gap:3px 18px;margin:0;font-size:14px}
dt{color:var(--muted)}dd{margin:0;overflow-wrap:anywhere}
.legend{display:flex;flex-wrap:wrap;gap:4px 18px;font-size:13px;color:var(--muted);margin:8px 0 0;align-items:center}
.legend + p{margin-top:10px}
.legend svg{display:inline-block;width:26px;height:14px;vertical-align:-2px;margin-right:6px}
.scale{display:inline-block;width:90px;height:9px;border-radius:5px;margin:0 6px;vertical-align:-1px;
background:linear-gradient(90deg,hsl(170 62% 42%),hsl(161 62% 42%) 25%,hsl(135 62% 42%) 50%,hsl(91 62% 42%) 75%,hsl(30 62% 42%))}
svg{width:100%;height:auto;display:block}
svg text{font:11.5px system-ui,-apple-system,"Segoe UI",Roboto,sans-serif;fill:var(--ink)}
svg .tick{fill:var(--muted);font-size:11px}
svg .label{font-size:11px;fill:var(--ink);opacity:.75}
.grid{stroke:var(--line);stroke-width:1}.zero{stroke:var(--muted)}
.board{fill:var(--board);stroke:var(--board-edge);stroke-width:1.5}
.part{fill:var(--part);stroke:var(--part-edge)}.fixture{fill:var(--fixture);stroke:var(--fixture-edge)}
.zone{fill:var(--bad);fill-opacity:.08;stroke:var(--bad);stroke-width:1.2;stroke-dasharray:6 4}
.planned{fill:none;stroke:var(--planned);stroke-width:4.5;stroke-linejoin:round}
.actual{fill:none;stroke:var(--actual);stroke-width:1.1;stroke-linejoin:round}
.asked{fill:none;stroke:var(--muted);stroke-width:1.2;stroke-dasharray:4 3}
.limit{fill:none;stroke:var(--warn);stroke-width:1.2;stroke-dasharray:5 3}
.stopped{fill:none;stroke:var(--bad);stroke-width:2.4}
.order{font-size:10px;fill:var(--muted)}
.narrow{display:none}
@media screen and (max-width:640px){.wide{display:none}.narrow{display:inline}
svg.large .tick,.narrow .order,.narrow .label{font-size:32px}svg.large .below{transform:translateY(14px)}svg.small .tick{font-size:17px}
svg.large{overflow:visible}svg .narrow .order{fill:var(--ink)}}
h3{font-size:14px;font-weight:600;margin:12px 0 4px}
.bead{fill:none;stroke:var(--bead);stroke-linejoin:round;stroke-linecap:round}
.valve-dot{fill:var(--bead)}
.valve-band{fill:var(--band)}
.mark{fill:none;stroke:var(--accent);stroke-width:1.6}.mark-lost{stroke:var(--bad)}
.residual{stroke:var(--accent);stroke-width:2.2;stroke-linecap:round}
.touch{fill:var(--accent)}
.hit{fill:none;stroke:var(--bad);stroke-width:2}.cross{stroke:var(--bad);stroke-width:2.4;stroke-linecap:round}
.bar{fill:var(--accent)}
@media print{body{background:#fff}section,.tile{break-inside:avoid}.scroll{max-height:none;overflow:visible}
table{font-size:11px}th{font-size:10px}td,th,td.r,th.r{padding-right:6px;white-space:normal}
.prose{min-width:0}}
)css";

}  // namespace gantry::record
