#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# bench_page_test.sh BRUME: the page of `brume bench` in a headless browser: curves are drawn, the
# slider moves, nothing is fetched. Exit code 77, with a word, where there is no Chromium.
set -euo pipefail
brume=$(readlink -f "$1")
browser=
for name in chromium chromium-browser google-chrome; do
  browser=$(command -v "$name") && break
done
[[ -n $browser ]] || { echo "SKIPPED: no Chromium on this machine (Debian: apt-get install chromium)"; exit 77; }

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

cat > ball.pbrt <<'SCENE'
Film "image" "integer xresolution" 16 "integer yresolution" 12
Sampler "random" "integer pixelsamples" 8
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "infinite"
Volume "homogeneous" "point p0" [-1 -1 -1] "point p1" [1 1 1] "color sigma_s" [.5 .5 .5]
Material "matte"
Shape "sphere" "float radius" .5
WorldEnd
SCENE
cat > page.json <<'CONFIG'
{"title": "Page </script> test", "passes": 4, "threads": 1, "seeds": [1, 2], "foreign": "others.csv",
 "scenes": [{"file": "ball.pbrt", "reference": {"passes": 40}}],
 "methods": [{"integrator": "volpath"}, {"name": "single", "integrator": ["single", "path"]}]}
CONFIG
"$brume" ball.pbrt --quiet -o other.exr --seed 7
echo "Other,ball,0.01,other.exr" > others.csv
"$brume" bench page.json --quiet

# A page beside it looks into it.
cat > look.html <<'PAGE'
<!DOCTYPE html><html><body><pre id="result">the page was not looked at</pre>
<iframe id="frame" src="page-results/index.html" width="1200" height="3000"></iframe>
<script>
document.currentScript.remove();  // its text is not the result
const lines = [];
const check = (name, isGood, detail = '') => {
  lines.push(`${isGood ? 'ok' : 'NOT OK'} ${name} ${isGood ? '' : detail}`);
  document.getElementById('result').textContent = lines.join('\n');
};
const frame = document.getElementById('frame');
async function look() {
  const page = frame.contentDocument, all = (s, root = page) => [...root.querySelectorAll(s)];
  const input = (element, value) => { element.value = value; element.dispatchEvent(new frame.contentWindow.Event('input')); };
  check('title', page.title === 'Page <' + '/script> test', page.title);

  for (const y of ['relmse', 'flip']) {
    const curves = all(`svg.plot[data-y=${y}] path.curve`);
    check(`${y}: a curve for each method`, curves.length === 3, curves.length);
    const border = page.querySelector(`svg.plot[data-y=${y}] rect.frame`).getBoundingClientRect();
    for (const curve of curves.filter(c => c.dataset.name !== 'Other')) {
      const box = curve.getBoundingClientRect();
      check(`${y}: ${curve.dataset.name} is drawn inside the frame`, box.width > 0 && box.height > 5 && box.left >= border.left
        && box.right <= border.right && box.top >= border.top && box.bottom <= border.bottom, JSON.stringify([box, border]));
      const numbers = curve.getAttribute('d').split(/[ML ]/).slice(1).map(Number);
      check(`${y}: ${curve.dataset.name} has points`, numbers.length >= 16 && numbers.every(Number.isFinite), curve.getAttribute('d'));
    }
    check(`${y}: seeds`, all(`svg.plot[data-y=${y}] path.seed`).length === 4);
  }
  const before = page.querySelector('path.curve').getAttribute('d');
  input(page.getElementById('axis'), 'samples');
  check('another axis, another curve', page.querySelector('path.curve').getAttribute('d') !== before);
  // By the clock a busy machine may take the same time for all images; samples are what they are.
  for (const curve of all('svg.plot path.curve'))
    check(`${curve.dataset.name} against samples: as wide as its samples`, curve.getBoundingClientRect().width > 200);
  check('other renderers have no samples', all('svg.plot[data-y=relmse] path.curve').length === 2);
  check('times to error', all('table.times td').some(td => td.textContent.includes('(1 x)')));

  const compare = page.querySelector('.compare'), over = compare.querySelector('.over'), under = compare.querySelector('.under');
  await Promise.all([over, under].map(img => img.decode()));
  check('images are there', over.naturalWidth === 16 && over.naturalHeight === 12 && under.naturalWidth === 16);
  check('two images', over.src !== under.src);
  const box = over.getBoundingClientRect();
  const at = share => page.elementFromPoint(box.left + share * box.width, box.top + box.height / 2);
  const wipe = compare.querySelector('.wipe');
  input(wipe, 25);
  check('slider at 25: first image left of it', at(.2) === over);
  check('slider at 25: second image right of it', at(.3) === under);
  input(wipe, 75);
  check('slider at 75', at(.7) === over && at(.8) === under);
  input(compare.querySelector('.mode'), 1);
  compare.querySelector('.stage').click();
  check('flip: a click shows the other', at(.1) === under);
  compare.querySelector('.stage').click();
  check('flip: a click brings it back', at(.9) === over);
  const source = over.src;
  input(compare.querySelector('.layer'), 1);
  check('error map', over.src !== source);

  check('nothing was fetched', frame.contentWindow.performance.getEntriesByType('resource').length === 0);
  const violation = new Promise(done => {
    page.addEventListener('securitypolicyviolation', e => done(e.effectiveDirective));
    setTimeout(() => done('none'), 2000);
  });
  const failed = await frame.contentWindow.fetch('http://127.0.0.1:9/').then(() => 'fetched', () => 'refused');
  check('its policy forbids to fetch', failed === 'refused' && await violation === 'connect-src', await violation);
}
frame.addEventListener('load', () => look().catch(e => check('no exception', false, e.stack)).then(
  () => check('looked at all of it', true)));
</script></body></html>
PAGE
# Its virtual time may run out before a busy machine has decoded the images: then once more.
for attempt in 1 2 3; do
  "$browser" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --allow-file-access-from-files \
    --user-data-dir="$folder/profile" --no-first-run --virtual-time-budget=20000 --dump-dom "file://$folder/look.html" \
    > dom.txt 2> browser.txt || { cat browser.txt; exit 1; }
  grep -q "looked at all of it" dom.txt && break
done
grep -E '^(<.*>)?(ok|NOT OK|the page)' dom.txt | sed 's/<[^>]*>//g'
grep -q "looked at all of it" dom.txt || { echo "the browser did not get to the end"; cat browser.txt; exit 1; }
! grep -q "NOT OK" dom.txt
