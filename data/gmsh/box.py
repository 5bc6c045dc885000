# Writes the files beside it: python box.py FOLDER (gmsh 4.13).
import gmsh, sys
gmsh.initialize(); gmsh.option.setNumber("General.Terminal",0)
g=gmsh.model.geo
p=[g.addPoint(x,y,0,0.5) for x,y in [(0,0),(1,0),(2,0),(2,1),(1,1),(0,1)]]
l=[g.addLine(p[a],p[b]) for a,b in [(0,1),(1,2),(2,3),(3,4),(4,5),(5,0),(1,4)]]
left=g.addPlaneSurface([g.addCurveLoop([l[0],l[6],l[4],l[5]])])
right=g.addPlaneSurface([g.addCurveLoop([l[1],l[2],l[3],-l[6]])])
for c in (l[1],l[2],l[3],l[6]): g.mesh.setTransfiniteCurve(c,3)
g.mesh.setTransfiniteSurface(right); g.mesh.setRecombine(2,right)
a=g.extrude([(2,left)],0,0,1,[2],recombine=True); b=g.extrude([(2,right)],0,0,1,[2],recombine=True)
g.synchronize()
va=[t for d,t in a if d==3]; vb=[t for d,t in b if d==3]
m=gmsh.model
m.addPhysicalGroup(3,va,4,"prisms"); m.addPhysicalGroup(3,vb,9,"hexahedra"); m.addPhysicalGroup(3,va+vb,2,"all cells"); m.addPhysicalGroup(2,[left,right],1,"floor"); 
m.mesh.generate(3)
print([ (t,len(e)) for t,e in zip(*m.mesh.getElements()[:2])], len(m.mesh.getNodes()[0]))
out=sys.argv[1]
for v in (2.2,4.1):
  for bn in (0,1):
    gmsh.option.setNumber("Mesh.MshFileVersion",v); gmsh.option.setNumber("Mesh.Binary",bn)
    gmsh.option.setNumber("Mesh.SaveAll",0)
    gmsh.write(f"{out}/box_v{str(v).replace('.','')}{'_bin' if bn else ''}.msh")
gmsh.option.setNumber("Mesh.Binary",0)
gmsh.option.setNumber("Mesh.MshFileVersion",4.1)
gmsh.option.setNumber("Mesh.SaveAll",1); gmsh.write(f"{out}/box_v41_all.msh")
gmsh.option.setNumber("Mesh.SaveParametric",1); gmsh.write(f"{out}/box_v41_parametric.msh"); gmsh.option.setNumber("Mesh.SaveParametric",0)
m.mesh.partition(2); gmsh.option.setNumber("Mesh.SaveAll",0); gmsh.write(f"{out}/box_v41_partitioned.msh"); m.mesh.unpartition()
m.mesh.setOrder(2); gmsh.write(f"{out}/box_v41_order2.msh")
